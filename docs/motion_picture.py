"""Pictures of motion: what is proven of a way, and a way into a harvest posture."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import agrik_fast as ik
from agrik_fast import harvest, motion
from agrik_fast.plots import BAD, FIELD, GOOD, PAGE_WIDTH, label


def draw_proof(file, save):
    """Draw the clearance along a path, and what is proven of each piece of it."""
    arm, scene = ik.Robot.load("cucumber"), harvest.example_scene()
    path = harvest.plan(arm, scene, ["C1"], path=True)["C1"].path
    aimed = scene.aiming_at("C1")
    figure, axis = plt.subplots(figsize=(PAGE_WIDTH, 2.8), layout="constrained")
    for k, (a, b) in enumerate(zip(path.path[:-1], path.path[1:], strict=True)):
        at = np.linspace(0, 1, 60)
        away = aimed.clearance(arm, a + at[:, None] * (b - a), cap=0.1, own=True)
        axis.plot(k + at, 1e3 * away, color=GOOD, lw=1.2, label=None if k else "at samples")
        kept = 1e3 * path.clearance[k]
        axis.plot([k, k + 1], [kept, kept], color=BAD, lw=2, label=None if k else "proven")
    axis.set(xlabel="piece of the path", ylabel=label("distance", "mm"), ylim=(0, None))
    axis.legend()
    save(figure, Path(file))


def draw_path(file, save):
    """Draw the tool point's way to a fruit from above and from the side."""
    arm, scene = ik.Robot.load("cucumber"), harvest.example_scene()
    figure, axes = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 3.0), layout="constrained")
    for name, color in (("C1", GOOD), ("C4", BAD)):
        plan: motion.Plan = harvest.plan(arm, scene, [name], path=True)[name].path
        ways = zip(plan.path[:-1], plan.path[1:], strict=True)
        q = np.concatenate([a + np.linspace(0, 1, 40)[:, None] * (b - a) for a, b in ways])
        tool = arm.fk(q)[:, :3, 3]
        for axis, (i, j) in zip(axes, ((1, 0), (1, 2)), strict=True):
            axis.plot(tool[:, i], tool[:, j], color=color, label=f"{name}: {plan.how}")
    for kind, words in (("fruit", "fruit"), ("leaf", "leaves")):
        points = np.concatenate([one.spheres for one in scene.objects if one.kind == kind])
        for axis, (i, j) in zip(axes, ((1, 0), (1, 2)), strict=True):
            look = {"s": 3, "color": FIELD[kind], "alpha": 0.4, "zorder": 1}
            axis.scatter(points[:, i], points[:, j], label=words, **look)
    for axis, which in zip(axes, ("x, into the row", "z, up"), strict=True):
        axis.set(xlabel=label("y, along the row", "m"), ylabel=label(which, "m"), aspect="equal")
    lines, names = axes[0].get_legend_handles_labels()
    figure.legend(lines, names, loc="outside lower center", ncols=4, markerscale=3)
    save(figure, Path(file))
