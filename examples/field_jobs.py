"""Two field jobs of redundant7: a spray pass with a nozzle, and topping cotton with a cutter.

`make run` calls this. What the jobs are is in `agrik_fast.papers.redundant7`.
"""

import sys

from agrik_fast.papers.redundant7 import cotton_topping, spray_pass


def main() -> int:
    """Run both jobs and say what came of them; 1 if a target is missed."""
    jobs = (spray_pass(), cotton_topping())
    for job in jobs:
        print(
            f"{job.name}: {int(job.success.sum())} of {len(job.points)} targets, "
            f"worst {1e6 * job.position_error.max():.1f} um off, nozzle "
            f"{1e6 * job.axis_error.max():.1f} urad, joints step {job.largest_step:.2f} rad at most"
        )
    return 0 if all(job.success.all() for job in jobs) else 1


if __name__ == "__main__":
    sys.exit(main())
