"""The commands, a file each; those that tell what there is share one.

Only typer is imported by them: ``--help`` must stay fast, so NumPy, the compiled module and rich
load inside the command that needs them.
"""

from .detect import detect
from .drive import drive
from .harvest import harvest
from .paper import paper
from .plan import plan
from .robots import convert, info, robots, schema, solvers
from .solve import SolveCommand, solve
from .tune import tune
from .view import view

__all__ = [
    "SolveCommand",
    "convert",
    "detect",
    "drive",
    "harvest",
    "info",
    "paper",
    "plan",
    "robots",
    "schema",
    "solve",
    "solvers",
    "tune",
    "view",
]
