"""Kills children at every step of a partition and prints how the last start left it.

    python kill_everywhere.py SOURCE TARGET

A program of its own, since it forks: a test's process has threads.
"""

import os
import signal
import sys
from pathlib import Path

from agrik_fast import Robot
from agrik_fast.jobs import (
    Assignment,
    FileSource,
    SolveJob,
    _partition,
    open_store,
    run_partition,
)


def main(source_place: str, target: str) -> None:
    source = FileSource(source_place)
    job = SolveJob(Robot.load("redundant7"), seed=4)
    assignment = Assignment(job, source.check(job))
    partition, store = source.partition(0), open_store(target)
    store.prepare()
    # Pieces grow as they would at once, so that all children have the same steps.
    _partition._PIECE_S = 1e9
    moment = 0
    while True:
        child = os.fork()
        if not child:
            left = moment

            def at_step(step: str) -> None:
                nonlocal left
                left -= 1
                if left < 0:
                    os.kill(os.getpid(), signal.SIGKILL)

            run_partition(assignment, partition, store, at_step)
            os._exit(0)
        _, status = os.waitpid(child, 0)
        names = sorted(path.name for path in Path(target).iterdir())
        there = [name for name in names if not name.startswith(".")]
        print(moment, os.waitstatus_to_exitcode(status), *there)
        if status == 0:
            return
        # What was placed before its record is not believed: every start does the work again.
        moment += 1


if __name__ == "__main__":
    main(*sys.argv[1:])
