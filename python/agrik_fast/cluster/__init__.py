"""Many targets on many processes or machines, resumable, every result exactly once.

`solve`, `forward` and `harvest` run over folders of Parquet files; `run` does so with any job of
`agrik_fast.jobs`. `status`, `verify` and `clean` look after a folder of results. `map_partitions`
and `futures` are for graphs of one's own in Dask.
"""

from ._calls import forward, harvest, run, solve
from ._collections import futures, map_partitions
from ._dask import LostError, Tls
from ._folder import FolderStatus, Verified, clean, status, verify
from ._run import Failure, Progress, Summary

__all__ = [
    "Failure",
    "FolderStatus",
    "LostError",
    "Progress",
    "Summary",
    "Tls",
    "Verified",
    "clean",
    "forward",
    "futures",
    "harvest",
    "map_partitions",
    "run",
    "solve",
    "status",
    "verify",
]
