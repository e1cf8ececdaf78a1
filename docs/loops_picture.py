"""Picture of a control loop, tick by tick: a target that leaves the reach and comes back."""

from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt

import agrik_fast as ik
from agrik_fast.plots import BAD, GOOD, GREY, PAGE_WIDTH

MOST = 0.02
OUT = (200, 320)


def drive(arm):
    """Return where the target is, and what the loop and plain warm-started calls make of it."""
    begin = np.array([0.3, -1.2, 1.4, -0.6, 1.2, 0.2])
    turn = 0.8 * np.sin(np.linspace(0, 2 * np.pi, 520))
    poses = arm.fk(begin + turn[:, None] * np.array([1.0, 0.3, -0.2, 0.1, 0.1, 0.5]))
    first, last = OUT
    away = np.zeros(len(poses))
    away[first:last] = 1.2 * np.sin(np.linspace(0, np.pi, last - first)) ** 2
    poses[:, :3, 3] *= 1 + away[:, None]
    loop, q, plain = arm.solver(max_change=MOST), begin, begin
    rows = []
    for pose in poses:
        loop.solve(pose, q)
        answer = arm.ik(pose, q0=plain)
        change = abs(loop.q - q).max()
        jump = abs(answer.q - plain).max()
        rows.append((change, jump, loop.position_error, loop.status == ik.Status.HELD))
        q, plain = loop.q, answer.q
    return np.array(rows)


def draw(file: Path, save) -> None:
    """Draw the largest change of a tick and the error that is left."""
    rows = drive(ik.Robot.load("ur5"))
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(PAGE_WIDTH, 4.4), sharex=True, layout="constrained"
    )
    ticks = np.arange(len(rows))
    above.semilogy(ticks, np.maximum(rows[:, 1], 1e-5), color=BAD, label="ik(q0=last)")
    above.semilogy(ticks, np.maximum(rows[:, 0], 1e-5), color=GOOD, label="solver(max_change=0.02)")
    above.axhline(MOST, color="black", linewidth=0.8, linestyle=":")
    above.set_ylabel("largest change [rad]")
    below.semilogy(ticks, np.maximum(rows[:, 2], 1e-8), color=GOOD)
    for axis in (above, below):
        axis.fill_between(
            ticks,
            *axis.get_ylim(),
            where=rows[:, 3] > 0,
            color=GREY,
            alpha=0.2,
            linewidth=0,
            label="status HELD",
        )
    above.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
    below.set_ylabel("distance to the target [m]")
    below.set_xlabel("tick")
    save(figure, file)
