"""Pictures of motion: what is proven of a way, and a way into a harvest posture."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import agrik_fast as ik
from agrik_fast import harvest, motion

GREEN, RUST, BLUE, GREY = "#2a7f62", "#c0532b", "#3b5ba5", "#8a8a8a"


def draw_proof(file, save):
    """Draw the clearance along a path, and what is proven of each piece of it."""
    arm, scene = ik.Robot.load("cucumber"), harvest.example_scene()
    path = harvest.plan(arm, scene, ["C1"], path=True)["C1"].path
    aimed = scene.aiming_at("C1")
    figure, axis = plt.subplots(figsize=(8, 3.2), layout="constrained")
    for k, (a, b) in enumerate(zip(path.path[:-1], path.path[1:], strict=True)):
        at = np.linspace(0, 1, 60)
        away = aimed.clearance(arm, a + at[:, None] * (b - a), cap=0.1, own=True)
        axis.plot(k + at, 1e3 * away, color=BLUE, lw=1.2, label=None if k else "at samples")
        kept = 1e3 * path.clearance[k]
        axis.plot([k, k + 1], [kept, kept], color=RUST, lw=2, label=None if k else "proven")
    axis.set(xlabel="piece of the path", ylabel="distance, mm", ylim=(0, None))
    axis.legend(frameon=False)
    save(figure, Path(file))


def draw_path(file, save):
    """Draw the tool point's way to a fruit from above and from the side."""
    arm, scene = ik.Robot.load("cucumber"), harvest.example_scene()
    figure, axes = plt.subplots(1, 2, figsize=(9, 4.2), layout="constrained")
    for name, color in (("C1", BLUE), ("C4", RUST)):
        plan: motion.Plan = harvest.plan(arm, scene, [name], path=True)[name].path
        ways = zip(plan.path[:-1], plan.path[1:], strict=True)
        q = np.concatenate([a + np.linspace(0, 1, 40)[:, None] * (b - a) for a, b in ways])
        tool = arm.fk(q)[:, :3, 3]
        for axis, (i, j) in zip(axes, ((1, 0), (1, 2)), strict=True):
            axis.plot(tool[:, i], tool[:, j], color=color, label=f"{name}: {plan.how}")
    for thing in scene.objects:
        color = {"fruit": GREEN, "leaf": "#7ab87a"}.get(thing.kind, GREY)
        points = thing.spheres
        if len(points) and thing.kind in ("fruit", "leaf"):
            for axis, (i, j) in zip(axes, ((1, 0), (1, 2)), strict=True):
                axis.scatter(points[:, i], points[:, j], s=3, color=color, alpha=0.4)
    for axis, label in zip(axes, ("x, m", "z, m"), strict=True):
        axis.set(xlabel="y (along the row), m", ylabel=label, aspect="equal")
    axes[0].legend(frameon=False, fontsize=8)
    save(figure, Path(file))
