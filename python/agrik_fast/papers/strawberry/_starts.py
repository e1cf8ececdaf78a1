"""Whether the paper's solutions are better starts for the nonlinear optimisation (NCOS).

The introduction says that a solution found by the proposed methods "can be used as the
initial guess for the NCOS to converge quicker".
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..._checks import FloatArray
from ...arms import StrawberryArm
from ...plots import PAGE_WIDTH, figure, styled
from .._output import save, write_csv
from ._published import targets

RANDOM_TARGETS = 60
GUESSES = ("home", "AS", "SSAS", "random")


class Guess(NamedTuple):
    """How NCOS does from a kind of start.

    Attributes
    ----------
    targets : str
        "table 3" (20) or "random" (60, which the exact method reaches).
    start : str
        home, AS, SSAS or random.
    reached : int
        Targets reached.
    of : int
        Targets.
    least : int
        How many of these with the least energy, to 1e-6 J.
    iterations : float
        Mean of SLSQP's iterations over the targets reached.
    milliseconds : float
        Time of a target, all counted.
    """

    targets: str
    start: str
    reached: int
    of: int
    least: int
    iterations: float
    milliseconds: float


def random_targets(arm: StrawberryArm, count: int = RANDOM_TARGETS, seed: int = 2) -> FloatArray:
    """Return targets of the whole box, shape (count, 3), m, that can be reached."""
    low, high = arm.target_box
    points = low + np.random.default_rng(seed).random((4 * count, 3)) * (high - low)
    return np.asarray(points[arm.solve(points).success][:count])


def guesses(arm: StrawberryArm | None = None) -> list[Guess]:
    """Return how NCOS does from home, from AS, from SSAS and from random joint values.

    Where AS or SSAS has no solution its start is home, as the failed rows hold.
    """
    arm = StrawberryArm() if arm is None else arm
    rows = []
    for name, points in (("table 3", targets()), ("random", random_targets(arm))):
        least = arm.solve(points).energy
        drawn = np.random.default_rng(3).random((len(points), 5))
        starts = {
            "home": np.broadcast_to(arm.reset_pose, (len(points), 5)),
            "AS": arm.solve(points, "as").q,
            "SSAS": arm.solve(points, "ssas").q,
            "random": arm.lower + (arm.upper - arm.lower) * drawn,
        }
        for start in GUESSES:
            begin = time.thread_time()
            found = arm.solve(points, "ncos", q0=starts[start])
            seconds = time.thread_time() - begin
            good = found.success
            rows.append(
                Guess(
                    name,
                    start,
                    int(good.sum()),
                    len(points),
                    int((np.abs(found.energy[good] - least[good]) < 1e-6).sum()),
                    float(found.iterations[good].mean()),
                    1000 * seconds / len(points),
                )
            )
    return rows


def guess_report(rows: list[Guess]) -> list[str]:
    """Return the table and its verdict in Markdown."""
    lines = [
        "# Starts of the NCOS",
        "",
        "| targets | start | reached | least energy | iterations | time a target, ms |",
        "|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {row.targets} | {row.start} | {row.reached} of {row.of} | {row.least} "
        f"| {row.iterations:.1f} | {row.milliseconds:.1f} |"
        for row in rows
    ]
    by_name = {(row.targets, row.start): row for row in rows}
    home, guess = by_name["table 3", "home"], by_name["table 3", "AS"]
    other = by_name["table 3", "SSAS"]
    far_home, far_guess = by_name["random", "home"], by_name["random", "AS"]
    return [
        *lines,
        "",
        '"Converge quicker" holds for the AS: on table 3 it needs '
        f"{guess.iterations:.1f} iterations for home's {home.iterations:.1f}; not surely for the "
        f"SSAS ({other.iterations:.1f}), which is no nearer in all five joint values. On targets "
        f"of the whole box a start does more: from AS {far_guess.reached} of {far_guess.of} are "
        f"reached, from home {far_home.reached}. All that is reached has the least energy.",
    ]


@styled
def write_guesses(directory: Path, rows: list[Guess]) -> list[Path]:
    """Write and draw the table; return the files."""
    drawing = figure(PAGE_WIDTH, 2.8)
    share, count = drawing.subplots(1, 2)
    place = np.arange(len(GUESSES))
    for k, name in enumerate(("table 3", "random")):
        own = [row for row in rows if row.targets == name]
        label = "targets of table 3" if k == 0 else "random targets in reach"
        at = place + 0.4 * k - 0.2
        share.bar(at, [100 * row.reached / row.of for row in own], 0.38, label=label)
        count.bar(at, [row.iterations for row in own], 0.38)
    share.set_ylabel("reached [%]")
    count.set_ylabel("mean iterations")
    for axes in (share, count):
        axes.set_xticks(place, GUESSES)
        axes.set_xlabel("start of the NCOS")
    drawing.legend(loc="outside upper center", ncols=2)
    return [
        write_csv(
            directory / "starts.csv",
            Guess._fields,
            [(*row[:5], f"{row.iterations:.2f}", f"{row.milliseconds:.2f}") for row in rows],
        ),
        *save(drawing, directory, "starts"),
    ]
