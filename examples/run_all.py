"""Solve every file in examples/targets, check the answers and print one row per robot.

`make run` calls this. The answers are read back from the result files and checked by the
plain NumPy forward kinematics of the tests, not by the library.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

from agrik_fast.cli.progress import for_stream
from agrik_fast.cli.summary import print_summaries
from agrik_fast.jobs import SolveRequest, Summary, solve_file

Vector = tuple[float, float, float]
X: Vector = (1.0, 0.0, 0.0)
DOWN: Vector = (0.0, 0.0, -1.0)

EXAMPLES = Path(__file__).resolve().parent
TARGETS = EXAMPLES / "targets"
RESULTS = EXAMPLES / "results"


@dataclass(frozen=True)
class Job:
    """A robot, its target file and where the results go."""

    robot: str
    targets: str
    result: str
    task: str | None = None
    tool_axis: Vector = (0.0, 0.0, 1.0)
    direction: Vector | None = None

    def request(self, results: Path) -> SolveRequest:
        """Return what `solve_file` is asked for."""
        return SolveRequest(
            robot=self.robot,
            targets=TARGETS / self.targets,
            output=results / self.result,
            task=self.task,
            tool_axis=self.tool_axis,
            direction=self.direction,
            force=True,
        )


JOBS = (
    Job("strawberry", "strawberry_table3.csv", "strawberry.csv"),
    Job("redundant7", "redundant7_pose.csv", "redundant7.csv"),
    Job("hydrolek", "hydrolek_workspace.csv", "hydrolek.csv"),
    Job("tomato", "tomato_points.npy", "tomato.npy"),
    # The gripper takes the fruit with its x axis down, free to turn about it.
    Job("cucumber", "cucumber_grips.csv", "cucumber.csv", "axis", X, DOWN),
    Job("puma560", "puma560_poses.npz", "puma560.npz"),
    Job("ur5", "ur5_poses.parquet", "ur5.parquet"),
    Job("panda", "panda_poses.npz", "panda.npz"),
)


def main() -> int:
    """Run all jobs; 1 if an answer that is called solved is not."""
    # The check is the tests' own code, so that the library does not vouch for itself.
    sys.path.insert(0, str(EXAMPLES.parent / "tests"))
    from independent_check import count_within_tolerance

    RESULTS.mkdir(exist_ok=True)
    summaries: list[Summary] = []
    wrong = 0
    for job in JOBS:
        request = job.request(RESULTS)
        summary = solve_file(request, for_stream(sys.stderr))
        checked = count_within_tolerance(request)
        if checked != summary.solved:
            wrong += 1
            print(f"{job.robot}: {summary.solved} called solved, {checked} within tolerance")
        summaries.append(summary)
    print_summaries(summaries, sys.stdout)
    solved = sum(summary.solved for summary in summaries)
    if not wrong:
        print(f"All {solved} solved rows confirmed by an independent NumPy forward kinematics.")
    print(f"Targets: {_shown(TARGETS)}  results: {_shown(RESULTS)}")
    drive_rigs()
    return 1 if wrong else 0


def drive_rigs() -> None:
    """Drive the simulated rigs to a target each, where they can be built."""
    from agrik_fast.drivers import SimulatorError, StrawberryRig, TomatoRig

    try:
        with StrawberryRig() as berry:
            berry.home()
            run = berry.pick(target=[0.426, 0.345, -0.3316])
            berry.reset()
        with TomatoRig() as tomato:
            tomato.home()
            tomato.move(target=[0.2, 0.05, 0.1])
    except SimulatorError as error:
        print(f"NOT CHECKED: the simulated rigs ({error})")
    else:
        print(f"Simulated rigs: a strawberry picked in {run.seconds:.1f} s, a tomato pointed at.")


def _shown(folder: Path) -> str:
    here = Path.cwd()
    return str(folder.relative_to(here) if folder.is_relative_to(here) else folder)


if __name__ == "__main__":
    sys.exit(main())
