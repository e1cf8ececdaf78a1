"""Side-by-side measurement of agrik_fast and other IK libraries (see benches/README.md)."""
