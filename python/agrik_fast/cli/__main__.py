"""``python -m agrik_fast.cli`` is ``agrik-fast``."""

from ._app import main

main()
