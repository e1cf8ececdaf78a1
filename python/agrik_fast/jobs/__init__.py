"""Jobs: targets from a file, results to a file; and work on partitions, done exactly once."""

from ._formula import FormulaSource
from ._job import MIXED, Assignment, Done, Job, JobError, canonical, difference
from ._partition import Cancelled, Finished, finished, run_partition
from ._places import is_url, open_store
from ._process import about_process, change_threads, using_threads
from ._progress import Progress, Silent
from ._record import Record
from ._robot_choice import RobotChoice
from ._solve_file import SolveRequest, faults_of, solve_file
from ._solve_job import ForwardJob, SolveJob, load_robot
from ._sources import MANIFEST, PARTITION_ROWS, FileSource, Partition, Source
from ._split import split_file
from ._store import Store
from ._summary import Summary

__all__ = [
    "MANIFEST",
    "MIXED",
    "PARTITION_ROWS",
    "Assignment",
    "Cancelled",
    "Done",
    "FileSource",
    "Finished",
    "FormulaSource",
    "ForwardJob",
    "Job",
    "JobError",
    "Partition",
    "Progress",
    "Record",
    "RobotChoice",
    "Silent",
    "SolveJob",
    "SolveRequest",
    "Source",
    "Store",
    "Summary",
    "about_process",
    "canonical",
    "change_threads",
    "difference",
    "faults_of",
    "finished",
    "is_url",
    "load_robot",
    "open_store",
    "run_partition",
    "solve_file",
    "split_file",
    "using_threads",
]
