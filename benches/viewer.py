"""How long a hand waits in the viewer: from a move of the pointer to the changed status.

The target is dragged to and fro in Chromium without a window (``.ci/browser`` installs it), with
software graphics; the times are taken in the page itself. Run it with the tests on the path:

    PYTHONPATH=tests/viewer python benches/viewer.py
"""

import argparse
import os
import platform

import numpy as np
from browser import chromium, drag_times, wait_for

import agrik_fast as ik
from agrik_fast.viewer import view

POSTURES = {
    "redundant7": [-2.4, 0.6, 0.1, 0.9, 0.2, 0.8, 0.0],
    "panda": [-2.4, 0.3, 0.1, -1.6, 0.1, 2.0, 0.4],
    "ur5": [-0.5, -1.2, 1.6, -0.4, 1.2, 0.3],
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--moves", type=int, default=100)
    moves = parser.parse_args().moves
    load = " ".join(f"{value:.1f}" for value in os.getloadavg())
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores, load {load}")
    print(f"{'robot':12} {'min':>7} {'p50':>7} {'p95':>7}   ms, of {moves} moves")
    with chromium() as page:
        page.size(1000, 640)
        for name, q in POSTURES.items():
            with view(name, port=0, open_browser=False) as viewer:
                viewer.aim(ik.Robot.load(name).fk(q))
                page.open(viewer.url)
                wait_for(lambda: "CONVERGED" in page.status, "the status")
                times = 1000 * drag_times(page, viewer, moves)
            low, middle, high = times.min(), np.median(times), np.percentile(times, 95)
            print(f"{name:12} {low:7.1f} {middle:7.1f} {high:7.1f}")


if __name__ == "__main__":
    main()
