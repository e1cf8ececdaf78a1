"""Figures of the cucumber paper, drawn from what the code computes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import harvest
from ...collision import Scene
from ...collision.drawing import draw_scene
from ...harvest import Decision, Runs
from ...harvest.drawing import draw_arm
from ...harvest.scans import approach_scan, slide_table
from ...plots import GREY, PAGE_WIDTH, PALETTE, add_triangles, figure, frame_space
from ...robot import Robot
from .._output import save
from ._published import GENETIC

ROBOT = "cucumber"
VIEWS = ((18, -125), (65, -90))
Array = NDArray[np.float64]


def _space(drawing: Any, place: tuple[int, int, int]) -> Any:
    return drawing.add_subplot(*place, projection="3d")


def _frame(axes: Any, view: tuple[float, float]) -> None:
    frame_space(axes, [-0.25, -0.75, 0.5], [0.9, 0.75, 1.6], view)


def robot(directory: Path) -> list[Path]:
    """Figures 1 and 2: the arm on its slide, and its axes."""
    arm = Robot.load(ROBOT)
    q = np.array([0.5, 0.0, -np.pi / 2, 0.0, 0.0, 0.0, np.pi])
    scene = harvest.example_scene()
    machine = Scene([one for one in scene.objects if one.kind == "machine"])
    drawing = figure(PAGE_WIDTH, 5.4)
    axes = _space(drawing, (1, 1, 1))
    draw_scene(axes, machine.objects)
    draw_arm(axes, arm, q)
    frame_space(axes, [-0.5, -1.0, 0.0], [0.9, 1.0, 1.6], (18, -60))
    axes.set_title("six-axis arm on a slide along the row")
    files = save(drawing, directory, "figure1")
    drawing = figure(PAGE_WIDTH, 5.4)
    axes = _space(drawing, (1, 1, 1))
    frames = arm.fk_links(q)
    points = np.concatenate([arm.base[None, :3, 3], frames[:, :3, 3]])
    axes.plot(*points.T, "-o", color="black", linewidth=2)
    for k, pose in enumerate(frames[:-1]):
        axes.quiver(*pose[:3, 3], *(0.14 * pose[:3, 2]), color=PALETTE[1])
        axes.text(*(pose[:3, 3] + 0.15 * pose[:3, 2]), arm.joint_names[k], color=PALETTE[1])
    tool = frames[-1]
    for axis, colour in zip(range(3), (PALETTE[1], PALETTE[2], PALETTE[0]), strict=True):
        axes.quiver(*tool[:3, 3], *(0.1 * tool[:3, axis]), color=colour)
    frame_space(axes, [-0.2, -0.4, 0.5], [0.8, 0.4, 1.5], (18, -60))
    axes.set_title("axes of the joints and frame of the tool")
    return files + save(drawing, directory, "figure2")


def vertical(directory: Path) -> list[Path]:
    """Figure 3: a cucumber hangs straight down, so the approach angle is free."""
    drawing = figure(PAGE_WIDTH, 5.4)
    axes = _space(drawing, (1, 1, 1))
    arm, scene = Robot.load(ROBOT), harvest.example_scene("cucumber_thin")
    point = np.array(scene.targets["C1"].point)
    for psi, colour in ((-40, PALETTE[5]), (0, PALETTE[4]), (40, PALETTE[3])):
        settings = harvest.Settings(range=np.radians(abs(psi)), angles=1 if psi == 0 else 3)
        found = harvest.plan(arm, scene, "C1", settings=settings, method="full")["C1"]
        table = slide_table(arm, scene, "C1", np.radians(psi))
        rows = np.flatnonzero(table["admissible"])
        if len(rows):
            draw_arm(axes, arm, table["q"][rows[table["score"][rows].argmax()]], colour, 0.25)
        elif found.ok:
            draw_arm(axes, arm, found.q, colour, 0.25)
        way = 0.35 * np.array([np.cos(np.radians(psi)), np.sin(np.radians(psi)), 0])
        axes.quiver(*(point - way), *way, color=colour, arrow_length_ratio=0.2)
    draw_scene(axes, [one for one in scene.objects if one.kind == "fruit"])
    _frame(axes, (30, -115))
    axes.set_title("three positions and the turn about the vertical: four degrees of freedom")
    return save(drawing, directory, "figure3")


def crop(directory: Path, scene: Scene) -> list[Path]:
    """Figure 4: the made-up crop, two views."""
    drawing = figure(PAGE_WIDTH, 3.6)
    for k, view in enumerate(VIEWS):
        axes = _space(drawing, (1, 2, k + 1))
        draw_scene(axes, scene.objects, skip=("machine",))
        _frame(axes, view)
    return save(drawing, directory, "figure4")


def _postures(
    directory: Path, name: str, scene: Scene, postures: list[tuple[str, Array]]
) -> list[Path]:
    arm = Robot.load(ROBOT)
    drawing = figure(min(3.25 * max(len(postures), 1.5), PAGE_WIDTH), 3.9)
    for k, (title, q) in enumerate(postures):
        axes = _space(drawing, (1, len(postures), k + 1))
        draw_scene(axes, scene.objects, skip=("machine",))
        draw_arm(axes, arm, q)
        _frame(axes, VIEWS[0])
        axes.set_title(title)
    return save(drawing, directory, name)


def genetic(directory: Path, scene: Scene, runs: Runs) -> list[Path]:
    """Figure 5: the best and the poorest optimum of the genetic algorithm, and their space."""
    order = np.argsort(runs.terms.cost)
    shown = [
        (
            f"seed {runs.seeds[k]}: J {runs.terms.cost[k]:.3g},\n"
            f"{1e3 * runs.terms.distance[k]:.0f} mm free",
            runs.q[k],
        )
        for k in (int(order[0]), int(order[-1]))
    ]
    return _postures(directory, "figure5", scene, shown)


def scans(directory: Path, scene: Scene, name: str = "C1") -> list[Path]:
    """Figures 6 to 8: the scan of angles, its best, and the scan of the slide."""
    scan = approach_scan(ROBOT, scene, name)
    psi = np.degrees(scan["psi"])
    drawing = figure(PAGE_WIDTH, 3.4)
    axes = drawing.add_subplot()
    axes.plot(psi, 1e3 * scan["hard"], label="gripper and flange")
    axes.plot(psi, 1e3 * scan["soft"], "--", label="wrist and forearm, wrist straight")
    best = int(np.flatnonzero(scan["rank"] == 0)[0])
    axes.axvline(psi[best], color=PALETTE[1], label=f"best, {psi[best]:.1f}°")
    axes.set_xlabel("approach angle [°]")
    axes.set_ylabel("distance from the crop [mm]")
    axes.legend()
    files = save(drawing, directory, "figure6")
    table = slide_table(ROBOT, scene, name, float(scan["psi"][best]))
    admissible = np.flatnonzero(table["admissible"])
    chosen = admissible[table["score"][admissible].argmax()]
    title = f"{psi[best]:.1f}°: {1e3 * scan['hard'][best]:.0f} mm round the gripper"
    files += _postures(directory, "figure7", scene, [(title, table["q"][chosen])])
    drawing = figure(PAGE_WIDTH, 3.4)
    axes = drawing.add_subplot()
    for branch in np.unique(table["branch"]):
        rows = table["branch"] == branch
        axes.plot(
            1e3 * table["slide"][rows],
            1e3 * np.maximum(table["distance"][rows], 0),
            ".-",
            label=f"branch {branch}",
        )
    axes.plot(
        1e3 * table["slide"][chosen],
        1e3 * table["distance"][chosen],
        "k*",
        markersize=14,
        label="chosen",
    )
    axes.set_xlabel("place of the slide [mm]")
    axes.set_ylabel("distance from the crop [mm]")
    axes.legend()
    return files + save(drawing, directory, "figure8")


def compared(
    directory: Path, scene: Scene, two_step: Decision, runs: dict[str, Runs], costs: Array
) -> list[Path]:
    """Figure 9: what the two-step method, GA and DE find, side by side."""
    shown = [
        (f"two-step: J {costs[0]:.3g},\n{1e3 * two_step.exact_distance:.0f} mm free", two_step.q)
    ]
    for name, of in runs.items():
        best = int(of.terms.cost.argmin())
        away = float(np.linalg.norm(of.q[best] - two_step.q))
        title = (
            f"{name}: J {of.terms.cost[best]:.3g},\n{1e3 * of.terms.distance[best]:.0f} mm free,\n"
            f"{away:.2f} from two-step"
        )
        shown.append((title, of.q[best]))
    return _postures(directory, "figure9", scene, shown)


def thinned(directory: Path, scene: Scene) -> list[Path]:
    """Figures 10 and 11 in kind: two fruits before and after leaves have been taken."""
    files = []
    for number, name in ((10, "C2"), (11, "C3")):
        found = harvest.blockers(ROBOT, scene, [name])[name]
        assert found is not None
        cleared = scene.without(*found.names)
        one = harvest.plan(ROBOT, cleared, name)[name]
        drawing = figure(PAGE_WIDTH, 3.6)
        gone = Scene([scene[leaf] for leaf in found.names])
        for k, shown in enumerate((scene, cleared)):
            axes = _space(drawing, (1, 2, k + 1))
            draw_scene(axes, shown.objects, skip=("machine",))
            if k == 0:
                rows = np.concatenate([leaf.spheres for leaf in gone.objects])
                axes.scatter(*rows[:, :3].T, color=PALETTE[1], marker="x", s=26)
                axes.set_title(f"{name}: {', '.join(found.names)} in the way")
            else:
                draw_arm(axes, Robot.load(ROBOT), one.q)
                axes.set_title(f"without: {1e3 * one.exact_distance:.0f} mm from the crop")
            _frame(axes, VIEWS[0])
        files += save(drawing, directory, f"figure{number}")
    return files


def boxes(directory: Path) -> list[Path]:
    """Figures A.1 and A.2: boxes of the links, and their spheres at three levels."""
    from ...collision import Box

    arm = Robot.load(ROBOT)
    q = np.array([0.5, 0.0, -np.pi / 2, 0.0, 0.0, 0.0, np.pi])
    drawing = figure(PAGE_WIDTH, 5.4)
    axes = _space(drawing, (1, 1, 1))
    draw_arm(axes, arm, q, alpha=0.4)
    frame_space(axes, [-0.35, -0.4, 0.5], [0.75, 0.4, 1.6], (15, -60))
    files = save(drawing, directory, "figureA1")
    drawing = figure(PAGE_WIDTH, 3.4)
    turn = np.linspace(0, 2 * np.pi, 25)
    poses = arm.fk_links(q)
    frames = arm.compiled_bodies().frames
    parts = {part.name: part for part in arm.surfaces("bodies")}
    all_frames = arm.frames_of(q)
    for level in range(3):
        axes = _space(drawing, (1, 3, level + 1))
        for body, frame in zip(arm.bodies, frames, strict=True):
            if not isinstance(body.shape, Box) or frame == 0:
                continue
            half = np.array(body.shape.half)
            pose, cells = poses[frame - 1], 2**level
            radius = np.linalg.norm(half) / cells
            ticks = (2 * np.arange(cells) + 1 - cells) / cells
            grid = np.stack(np.meshgrid(ticks, ticks, ticks), axis=-1).reshape(-1, 3) * half
            grid = (grid + np.array(body.shape.centre)) @ pose[:3, :3].T + pose[:3, 3]
            for centre in grid:
                wave = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)]) * radius
                for order in ((0, 2, 1), (0, 1, 2), (2, 0, 1)):
                    rim = centre[:, None] + wave[list(order)]
                    axes.plot(*rim, color=PALETTE[0], linewidth=(1.2, 0.7, 0.3)[level])
            part = parts[body.name]
            add_triangles(axes, part.placed(all_frames), part.faces, PALETTE[4], 0.3)
        frame_space(axes, [-0.45, -0.5, 0.4], [0.85, 0.5, 1.7], (12, -75))
        axes.set_title(f"level {level}: {8**level} spheres a box")
    return files + save(drawing, directory, "figureA2")


def convergence(directory: Path, runs: dict[str, Runs], seconds: dict[str, float]) -> list[Path]:
    """Convergence of the searches, beside the two published runs."""
    drawing = figure(PAGE_WIDTH, 3.8)
    axes = drawing.add_subplot()
    for name, colour in (("GA", PALETTE[1]), ("DE", PALETTE[0])):
        for k, history in enumerate(runs[name].history):
            label = f"{name}, {seconds[name]:.2f} s a run" if k == 0 else None
            axes.semilogy(np.maximum(history, 1e-12), color=colour, alpha=0.6, label=label)
    for one in GENETIC:
        axes.plot(one.generations, one.cost, "k*", markersize=12)
        axes.annotate(
            f"paper {one.figure}, {one.seconds:.0f} s",
            (one.generations, one.cost),
            xytext=(-8, 6) if one.generations > 1000 else (10, -3),
            textcoords="offset points",
            ha="right" if one.generations > 1000 else "left",
            # Readable where curves pass behind it.
            bbox={"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 1},
        )
    axes.set_xlabel("generation")
    axes.set_ylabel("cost J")
    axes.legend()
    return save(drawing, directory, "convergence")


def shares(directory: Path, rows: list[list[Any]]) -> list[Path]:
    """Share harvestable against height and leaves removed."""
    drawing = figure(PAGE_WIDTH, 3.6)
    axes = drawing.add_subplot()
    for low, high in sorted({(row[1], row[2]) for row in rows}):
        here = [row for row in rows if (row[1], row[2]) == (low, high)]
        axes.plot(
            [row[0] for row in here],
            [100 * row[4] for row in here],
            "o-",
            label=f"{low:.2f} to {high:.2f} m",
        )
    axes.set_xlabel("lowest leaves removed a plant, of 8")
    axes.set_ylabel("fruits that can be picked [%]")
    axes.set_ylim(0, 100)
    axes.legend(title="height of the grip point")
    return save(drawing, directory, "crop_shares")


def sensitivity(directory: Path, scene: Scene) -> list[Path]:
    """Chance that a posture stays free against the distance that it keeps."""
    one = harvest.plan(ROBOT, scene, "C1")["C1"]
    drawing = figure(PAGE_WIDTH, 3.6)
    axes = drawing.add_subplot()
    chance = np.concatenate([np.linspace(0.5, 0.99, 60), np.linspace(0.99, 0.9999, 40)])
    for vision in (2e-3, 5e-3, 1e-2):
        found = harvest.sensitivity(ROBOT, scene, "C1", one.q, harvest.Errors(vision=vision))
        keep = [1e3 * found.min_distance(float(p)) for p in chance]
        axes.plot(keep, 100 * chance, label=f"vision {1e3 * vision:.0f} mm")
    axes.axvline(5, color=GREY, linestyle=":", label="5 mm, as is usual")
    axes.set_xlabel("distance kept from the crop [mm]")
    axes.set_ylabel("chance to stay free [%]")
    axes.legend()
    return save(drawing, directory, "sensitivity")
