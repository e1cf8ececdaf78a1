"""``python -m agrik_fast.cli`` is ``agrik-fast``."""

from .app import main

main()
