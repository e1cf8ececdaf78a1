"""``python -m agrik_fast`` is ``agrik-fast``."""

from .cli import main

main()
