"""Make the parts of the documentation that come from the code: pictures and tables."""

import dataclasses
import math
from pathlib import Path

import architecture_picture
import commands
import elements
import front_picture
import hardware_pictures
import loops_picture
import matplotlib as mpl
import motion_picture
import numpy as np
import ring_picture
import solids_picture
import trajectory_pictures
import vision_pictures

import agrik_fast as ik
from agrik_fast.papers import hydrolek, redundant7, strawberry, tomato
from agrik_fast.plots import BAD, GOOD, PAGE_WIDTH, PALE, PALETTE, label, styled
from agrik_fast.tuning.goals import joint_uniform

mpl.use("Agg")
# The same drawing has the same bytes, whoever makes it.
mpl.rcParams["svg.hashsalt"] = "agrik_fast"

from matplotlib import pyplot as plt  # noqa: E402 - after the choice of the backend

FIELD_ROBOTS = ("strawberry", "cucumber", "hydrolek", "tomato", "redundant7")
SAMPLES = 4000


def save(figure: plt.Figure, file: Path, **options: float) -> None:
    """Write a picture, the same bytes every time."""
    figure.savefig(file, metadata={"Date": None}, **options)
    plt.close(figure)


def draw_reach(file: Path) -> None:
    """Draw where the tool points of random joint vectors lie, seen from the side."""
    figure, axes = plt.subplots(2, 3, figsize=(PAGE_WIDTH, 4.6), layout="constrained")
    for axis, name in zip(axes.flat, FIELD_ROBOTS, strict=False):
        arm = ik.Robot.load(name)
        points = arm.fk(arm.random_q(SAMPLES, seed=0))[:, :3, 3]
        axis.plot(points[:, 0], points[:, 2], ".", markersize=1, color=GOOD, rasterized=True)
        axis.set_title(name)
        axis.set_xlabel("x [m]")
        axis.set_ylabel("z [m]")
        axis.set_aspect("equal", adjustable="datalim")
    axes.flat[-1].set_axis_off()
    save(figure, file, dpi=120)


def draw_arm_angles(file: Path) -> None:
    """Draw the arm angles that the limits allow for one pose of redundant7, by branch."""
    arm = ik.Robot.load("redundant7")
    pose = arm.fk([2.2, -1.3, 1.1, 1.4, -0.9, 1.2, 0.5])
    figure, axis = plt.subplots(figsize=(PAGE_WIDTH, 2.8), layout="constrained")
    for branch, intervals in enumerate(arm.arm_angle_intervals(pose)):
        for low, high in np.degrees(intervals):
            # The last interval may go through half a turn.
            for left in (low, low - 360):
                axis.barh(branch, high - low, left=left, height=0.6, color=GOOD)
    axis.set_xlim(-180, 180)
    axis.set_xticks(range(-180, 181, 60))
    axis.set_yticks(range(8))
    axis.set_xlabel(label("arm angle", "°"))
    axis.set_ylabel("branch")
    save(figure, file)


def draw_branches(file: Path) -> None:
    """Draw all branches of a pose of the PUMA 560, and one of redundant7 by arm angle."""
    figure = plt.figure(figsize=(PAGE_WIDTH, 4.6))
    puma = ik.Robot.load("puma560")
    pose = puma.fk([0.4, 0.9, -0.6, 0.5, 0.7, 0.2])
    found = puma.ik_all(pose)
    wrists = figure.add_subplot(1, 2, 1, projection="3d")
    names = ("first", "second", "third", "fourth")
    for number, name in enumerate(names):
        # Branches that differ in the wrist alone have their links in the same places.
        pair = slice(2 * number, 2 * number + 2)
        points = puma.fk_links(found.q[2 * number])[:, :3, 3]
        style = "-" if found.valid[pair].any() else ":"
        words = f"{name} pair" + ("" if style == "-" else ", out of limits")
        wrists.plot(*points.T, style, marker="o", markersize=4, linewidth=2.5, label=words)
    wrists.plot(*pose[:3, 3], "*", color="black", markersize=11, label="tool point")
    wrists.set_title("puma560: 8 branches,\n4 arms with 2 wrists each")

    arm = ik.Robot.load("redundant7")
    q = np.array([0.4, 0.7, 0.2, 1.5, 0.3, 0.6, 0.1])
    pose = arm.fk(q)
    angles = np.radians(np.arange(-180, 180, 5))
    turned = arm.ik_all(np.broadcast_to(pose, (len(angles), 4, 4)), arm_angle=angles)
    links = arm.fk_links(turned.q[:, 0])[..., :3, 3]
    circle = figure.add_subplot(1, 2, 2, projection="3d")
    for row in range(0, len(angles), 6):
        inside = turned.valid[row, 0]
        color, style = (GOOD, "-") if inside else (PALE, ":")
        circle.plot(*links[row].T, style, color=color, linewidth=1.5)
    at_zero = links[len(angles) // 2]
    circle.plot(*at_zero.T, color=BAD, linewidth=3, label="arm angle 0")
    # The elbow is the link that goes furthest round.
    elbow = int(np.ptp(links, axis=0).sum(axis=-1).argmax())
    ring = np.concatenate([links[:, elbow], links[:1, elbow]])
    circle.plot(*ring.T, color=PALETTE[2], linewidth=1, label="way of the elbow")
    circle.plot([], [], color=GOOD, label="every 30°, within limits")
    circle.plot([], [], ":", color=PALE, label="out of limits")
    circle.plot(*pose[:3, 3], "*", color="black", markersize=11, label="tool point")
    circle.set_title("redundant7: one branch\nof one pose, by arm angle")
    for axis in (wrists, circle):
        axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.05))
        axis.set_aspect("equal", adjustable="datalim")
        axis.set_box_aspect((1, 1, 1), zoom=0.9)
        axis.locator_params(nbins=3)
        axis.set_xlabel("x [m]")
        axis.set_ylabel("y [m]")
        axis.set_zlabel("z [m]")
    figure.subplots_adjust(left=0.0, right=0.93, bottom=0.26, top=0.92, wspace=0.12)
    save(figure, file)


def draw_laws(folder: Path) -> None:
    """Draw, for each method of Table II, the error over its steps, the others in grey."""
    arm = ik.Robot.load("hydrolek")
    goal = hydrolek.displaced_goal(arm, "zero")
    curves = {}
    for name, (solver, _) in hydrolek.methods().items():
        curves[name] = 1e3 * hydrolek.error_trace(arm, solver, goal, "zero", 60, 1e-6)
    pages = {
        "jacobian": tuple(
            name for name in curves if name.startswith(("pseudo", "trans", "damped"))
        ),
        "coordinate-descent": ("coordinate descent",),
        "ik-pid": ("IK-PID, published",),
        "state-space": ("state space, 90 (PSO)", "state space, 15 (CMA-ES)"),
        "static-gain": ("static gain, 15",),
        "broyden": ("Broyden from static gain",),
    }
    for page, names in pages.items():
        figure, axis = plt.subplots(figsize=(PAGE_WIDTH, 3), layout="constrained")
        others = [errors for name, errors in curves.items() if name not in names]
        for number, errors in enumerate(others):
            words = None if number else "the other methods"
            axis.semilogy(errors, color=PALE, linewidth=1, label=words)
        for name, style in zip(names, ("-", "--", "-.", ":"), strict=False):
            axis.semilogy(curves[name], style, label=name)
        axis.set_xlabel("steps (sweeps of all joints)")
        axis.set_ylabel("error [mm]")
        axis.legend()
        save(figure, folder / f"{page}.svg")


def draw_tuning(file: Path) -> None:
    """Draw how the goals left unreached fall from a frozen gain to a tuned one."""
    arm = ik.Robot.load("hydrolek")
    goals = joint_uniform(arm, 1000, 1)
    sets = {
        "trial_published": "by trial, as published",
        "full90_pso": "all 90 numbers, swarm",
        "diag24_pso": "24 numbers, swarm",
        "k15_pso": "gain of 15 numbers, swarm",
        "full90_cma": "all 90 numbers, CMA-ES",
        "k15_cma": "gain of 15 numbers, CMA-ES",
    }
    lines = ("-", "-", "--", "-.", ":", "--")
    figure, axis = plt.subplots(figsize=(PAGE_WIDTH, 3), layout="constrained")
    for (name, words), line in zip(sets.items(), lines, strict=True):
        solver = ik.solvers.StateSpace.load(f"hydrolek_{name}", as_tuned=True)
        result = arm.ik(goals, solver=solver, position_tolerance=1e-3)
        steps = np.sort(result.iterations[result.success])
        reached = np.arange(1, len(steps) + 1)
        axis.step(steps, reached, line, where="post", label=words)
    axis.set_xscale("log")
    axis.set_xlabel("steps")
    axis.set_ylabel("goals of 1,000 reached by then")
    # Beside the curves, in their order at the end, not over them.
    figure.legend(loc="outside right center")
    save(figure, file)


def draw_populations(folder: Path) -> None:
    """Draw the best cost by generation of the published recipe's variants, and of the GA."""
    arm, pose = ik.Robot.load("redundant7"), redundant7.target()
    recipe = ik.solvers.DifferentialEvolution.paper()
    genetic = ik.solvers.GeneticAlgorithm(
        population=100,
        generations=200,
        max_restarts=0,
        position_weight=recipe.position_weight,
        orientation_weight=recipe.orientation_weight,
        polish=False,
    )
    variants = {
        "differential-evolution": {
            "best1, rate per gene (published)": recipe,
            "best1, rate per individual": dataclasses.replace(recipe, redraw="individual"),
            "rand1": dataclasses.replace(recipe, mutation="rand1"),
            "current-to-best1": dataclasses.replace(recipe, mutation="current-to-best1"),
            "jDE": dataclasses.replace(recipe, adaptation="jde", crossover=(0.9, 0.9)),
        },
        "genetic-algorithm": {"genetic algorithm": genetic, "differential evolution": recipe},
    }
    for page, solvers in variants.items():
        figure, axis = plt.subplots(figsize=(PAGE_WIDTH, 3.2), layout="constrained")
        for name, solver in solvers.items():
            costs = [arm.cost_history(pose, solver, seed=seed) for seed in range(30)]
            axis.semilogy(np.median(costs, axis=0), label=name)
        axis.set_xlabel("generation")
        axis.set_ylabel("best cost, median of 30 [mm + 100 rad]")
        axis.legend()
        save(figure, folder / f"{page}.svg")


def describe(name: str) -> str:
    """Return the description of a robot and the table of its joints, as Markdown."""
    arm = ik.Robot.load(name)
    lines = [f"{arm.description}.", "", "| joint | kind | lower | upper |", "|---|---|---|---|"]
    for joint, kind, low, high in zip(
        arm.joint_names, arm.joint_types, arm.lower, arm.upper, strict=True
    ):
        if kind == "prismatic":
            limits = f"{low:.3f} m", f"{high:.3f} m"
        elif np.isfinite([low, high]).all():
            limits = f"{math.degrees(low):.2f}°", f"{math.degrees(high):.2f}°"
        else:
            limits = "none", "none"
        lines.append(f"| `{joint}` | {kind} | {limits[0]} | {limits[1]} |")
    lines += ["", f"No point farther than {arm.reach_radius:.3f} m from the centre of its reach."]
    return "\n".join(lines) + "\n"


@styled
def main(folder: Path) -> None:
    """Write everything into `folder`."""
    folder.mkdir(exist_ok=True)
    front_picture.draw(folder, save)
    draw_reach(folder / "reach.svg")
    draw_arm_angles(folder / "arm_angles.svg")
    draw_branches(folder / "branches.svg")
    ring_picture.draw(folder / "ring.svg", save)
    loops_picture.draw(folder / "loops.svg", save)
    strawberry.reproduce(folder / "papers" / "strawberry")
    tomato.reproduce(folder / "papers" / "tomato")
    hydrolek.reproduce(folder / "papers" / "hydrolek")
    redundant7.reproduce(folder / "papers" / "redundant7", repeats=200)
    text = elements.table(Path(__file__).parent / "papers" / "elements.csv")
    (folder / "papers" / "elements.md").write_text(text, encoding="utf-8")
    architecture_picture.main(folder / "architecture")
    solids_picture.draw_bodies(folder / "bodies.png", save)
    solids_picture.draw_greenhouse(folder / "scene.png", save)
    solids_picture.draw_clearance(folder / "clearance.svg", save)
    motion_picture.draw_proof(folder / "proof.svg", save)
    motion_picture.draw_path(folder / "way.svg", save)
    hardware_pictures.main(folder / "hardware")
    trajectory_pictures.draw(folder / "trajectories.svg", save)
    vision_pictures.main(folder / "vision")
    methods = folder / "methods"
    methods.mkdir(exist_ok=True)
    draw_laws(methods)
    draw_tuning(methods / "tuning.svg")
    draw_populations(methods)
    (folder / "commands.md").write_text(commands.page(), encoding="utf-8")
    for name in ik.Robot.names():
        (folder / f"{name}.md").write_text(describe(name), encoding="utf-8")
