"""Jobs: targets from a file, results to a file, in memory that does not grow with them."""

from ._progress import Progress, Silent
from ._robot_choice import RobotChoice
from ._solve_file import SolveRequest, solve_file
from ._summary import Summary

__all__ = ["Progress", "RobotChoice", "Silent", "SolveRequest", "Summary", "solve_file"]
