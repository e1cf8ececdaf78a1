"""Tables of the cucumber paper, computed anew."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ... import harvest
from ...collision import Box, Cover, Scene, greenhouse
from ...harvest import Distance, Programme, Runs, Terms
from ...harvest.scans import approach_scan, slide_table
from ...robot import Robot
from .._output import write_csv
from ._formulas import MISPRINTS, random_poses
from ._published import FIELD, GENETIC

__all__ = [
    "ABLATION",
    "ablation",
    "crop_shares",
    "field_cycle",
    "search_runs",
    "sensitivity_rows",
    "sphere_rows",
    "success_rows",
    "write_tables",
]

ROBOT = "cucumber"
SEEDS = 20
"""Runs of each search."""
ABLATION: dict[str, dict[str, Any]] = {
    "usual": {},
    "population 50": {"population": 50},
    "population 200": {"population": 200},
    "tournament 4": {"tournament": 4},
    "mutation rate 0.05": {"mutation_rate": 0.05},
    "mutation rate 0.3": {"mutation_rate": 0.3},
    "mutation does not shrink": {"mutation_end": 1.0},
    "crossover index 2": {"crossover_index": 2.0},
    "no elites": {"elites": 0},
}
"""Settings of the genetic algorithm that the paper leaves to further investigation."""


def write_tables(
    directory: Path,
    scene: Scene,
    programme: Programme,
    runs: dict[str, Runs],
    seconds: dict[str, float],
) -> list[Path]:
    """Write the tables that need no long computing."""
    return [
        _table1(directory / "table1.csv"),
        _misprints(directory / "misprints.csv"),
        _decisions(directory / "decisions.csv", scene),
        _searches(directory / "searches.csv", programme, runs, seconds),
        write_csv(
            directory / "success.csv",
            ["method", "runs", "within 1 mm and 1e-3", "median J", "J below 1e-6", "s a run"],
            success_rows(programme, runs, seconds),
        ),
        write_csv(
            directory / "spheres.csv",
            ["body", "half lengths, mm", "level", "spheres", "radius, mm", "overestimate, mm"],
            sphere_rows(),
        ),
    ]


def _table1(path: Path) -> Path:
    robot = Robot.load(ROBOT)
    assert robot.dh is not None
    letters = {"P": "printed", "D": "derived", "X": "sister arm", "A": "assumed"}
    rows = []
    for row in robot.dh:
        slides = row.type == "prismatic"
        scale = 1e3 if slides else 180 / np.pi
        said = ", ".join(
            f"{what.split('.')[1]}: {letters.get(word[:1], word)}"
            for what, word in robot.provenance.items()
            if what.split(".")[0] == row.name
        )
        rows.append(
            [
                row.name,
                1e3 * row.a,
                np.degrees(row.alpha),
                row.name if slides else 1e3 * row.d,
                np.degrees(row.theta) if slides else row.name,
                scale * row.lower,
                scale * row.upper,
                said,
            ]
        )
    head = ["joint", "a, mm", "alpha, deg", "d, mm", "theta, deg"]
    return write_csv(path, [*head, "lower, mm or deg", "upper, mm or deg", "provenance"], rows)


def _misprints(path: Path) -> Path:
    poses = random_poses()
    rows = [
        [one.place, one.printed, one.holds, one.error(poses), one.corrected(poses), one.unit]
        for one in MISPRINTS
    ]
    head = ["place", "as read", "holds", "error as read", "error corrected", "unit"]
    return write_csv(path, head, rows)


def _decisions(path: Path, scene: Scene) -> Path:
    rows = []
    ways: tuple[Distance, ...] = ("tree", "exact")
    for distance in ways:
        for method, settings in (
            ("two-step", harvest.Settings()),
            ("two-step, refined", harvest.Settings(refine=True)),
            ("full", harvest.Settings()),
        ):
            start = time.perf_counter()
            found = harvest.plan(
                ROBOT,
                scene,
                settings=settings,
                distance=distance,
                method="full" if method == "full" else "two-step",
                threads=1,
            )
            each = 1e3 * (time.perf_counter() - start) / len(found)
            rows += [
                [
                    one.name,
                    distance,
                    method,
                    one.status.name,
                    f"{one.open}/{one.angles}",
                    1e3 * one.distance,
                    1e3 * one.exact_distance,
                    one.freedom,
                    np.degrees(one.psi),
                    1e3 * one.slide,
                    one.branch,
                    each,
                ]
                for one in found
            ]
    head = ["target", "distance", "method", "status", "open angles", "D, mm", "exact D, mm"]
    return write_csv(
        path, [*head, "freedom", "psi, deg", "d1, mm", "branch", "mean ms a target"], rows
    )


def search_runs(
    programme: Programme, seeds: int = SEEDS
) -> tuple[dict[str, Runs], dict[str, float]]:
    """Return runs of the genetic algorithm and of differential evolution, and s a run."""
    runs, seconds = {}, {}
    for name, search in (("GA", programme.genetic), ("DE", programme.differential)):
        start = time.perf_counter()
        runs[name] = search(range(seeds), threads=1)
        seconds[name] = (time.perf_counter() - start) / seeds
    return runs, seconds


def _scanned(programme: Programme) -> tuple[Terms, float]:
    """Return the terms of the null-space scan's posture, one run, and the seconds it took."""
    start = time.perf_counter()
    found = programme.null_space()
    seconds = time.perf_counter() - start
    return programme.terms(found.q[None]), seconds


def success_rows(
    programme: Programme, runs: dict[str, Runs], seconds: dict[str, float]
) -> list[list[Any]]:
    """Return how often each method reaches the fruit, and how low its cost is.

    Parameters
    ----------
    programme : Programme
    runs : dict of str to Runs
    seconds : dict of str to float
        Of a run.

    Returns
    -------
    list of rows
        Method, runs, how many reach the fruit, median J, how many end below 1e-6, s a run.
    """
    scan, took = _scanned(programme)
    each = [(name, of.terms, seconds[name]) for name, of in runs.items()]
    return [
        [
            name,
            len(terms.cost),
            int(terms.accepted().sum()),
            float(np.median(terms.cost)),
            int((terms.cost < 1e-6).sum()),
            time_of_run,
        ]
        for name, terms, time_of_run in [*each, ("null-space scan", scan, took)]
    ]


def _searches(
    path: Path, programme: Programme, runs: dict[str, Runs], seconds: dict[str, float]
) -> Path:
    rows: list[list[Any]] = []
    for name, of in runs.items():
        rows += [
            [
                f"{name}, seed {seed}",
                of.terms.cost[k],
                1e3 * of.terms.position[k],
                of.terms.orientation[k],
                of.terms.nearness[k],
                1e3 * of.terms.distance[k],
                int(of.generations[k]),
                seconds[name],
            ]
            for k, seed in enumerate(of.seeds)
        ]
    scan, took = _scanned(programme)
    rows.append(
        [
            "null-space scan",
            scan.cost[0],
            1e3 * scan.position[0],
            scan.orientation[0],
            scan.nearness[0],
            1e3 * scan.distance[0],
            "",
            took,
        ]
    )
    rows += [
        [f"paper, figure {one.figure}", one.cost, "", "", "", "", one.generations, one.seconds]
        for one in GENETIC
    ]
    head = ["run", "J", "position, mm", "orientation", "nearness", "D, mm"]
    return write_csv(path, [*head, "generations", "s a run"], rows)


def sphere_rows() -> Iterable[list[Any]]:
    """Return the cover of each box, level by level: what the spheres overestimate."""
    for body in Robot.load(ROBOT).bodies:
        shape = body.shape.box if isinstance(body.shape, Cover) else body.shape
        if not isinstance(shape, Box):
            continue
        half = 1e3 * np.array(shape.half)
        for level in range(4):
            cell = half / 2**level
            radius = float(np.linalg.norm(cell))
            sizes = " ".join(f"{x:g}" for x in half)
            yield [body.name, sizes, level, 8**level, radius, radius - float(cell.min())]


def ablation(programme: Programme, seeds: int = 20, generations: int = 300) -> list[list[Any]]:
    """Return how each setting of the genetic algorithm changes what it finds.

    Parameters
    ----------
    programme : Programme
    seeds : int, default 20
    generations : int, default 300
        Fewer than usual, so that the settings differ.

    Returns
    -------
    list of rows
        Setting, median, best and worst J, and how many runs reach the fruit within 1 mm.
    """
    rows = []
    for name, options in ABLATION.items():
        runs = programme.genetic(range(seeds), generations=generations, **options)
        cost = runs.terms.cost
        near = int(runs.terms.accepted().sum())
        rows.append([name, float(np.median(cost)), float(cost.min()), float(cost.max()), near])
    return rows


def sensitivity_rows(scene: Scene, draws: int = 1500) -> list[list[Any]]:
    """Return errors of the tool and the chance to stay free of postures, formula and draws.

    Parameters
    ----------
    scene : Scene
    draws : int, default 1500

    Returns
    -------
    list of rows
        Target, distance (mm), rms of the tool by formula and by draws (mm), probability of
        the nearest body, union bound and draws, distance to keep for 99 % (mm).
    """
    rows = []
    for name in ("C1", "C4"):
        scan = approach_scan(ROBOT, scene, name)
        order = np.argsort(np.where(scan["rank"] < 0, len(scan["rank"]), scan["rank"]))
        shown = 0
        for k in order:
            table = slide_table(ROBOT, scene, name, float(scan["psi"][k]))
            free = np.flatnonzero(~table["hits_itself"] & (table["distance"] > 0.002))
            if not len(free):
                continue
            q = table["q"][free[len(free) // 2]]
            found = harvest.sensitivity(ROBOT, scene, name, q)
            drawn = harvest.simulate(ROBOT, scene, name, q, draws=draws)
            rows.append(
                [
                    name,
                    1e3 * float(found.clearance.min()),
                    1e3 * found.rms,
                    1e3 * drawn.rms,
                    found.nearest,
                    found.free_of_nearest,
                    drawn.free,
                    1e3 * found.min_distance(0.99),
                ]
            )
            shown += 1
            if shown == 5:
                break
    return sorted(rows, key=lambda row: (row[0], row[1]))


def crop_shares(
    crops: int = 8,
    heights: Iterable[tuple[float, float]] = ((0.8, 0.95), (0.95, 1.1), (1.1, 1.25)),
) -> list[list[Any]]:
    """Return the share harvestable against height and leaves removed, in made-up crops.

    Leaves are taken off from the bottom up, as growers do.

    Parameters
    ----------
    crops : int, default 8
        Rows of four plants, eight leaves and four fruits each.
    heights : iterable of (float, float), m
        Ranges of the grip points' heights.

    Returns
    -------
    list of rows
        Leaves removed a plant, range of heights (m), fruits and the share harvestable.
    """
    wanted = list(heights)
    rows = []
    for gone in (0, 2, 4, 6, 8):
        counts = np.zeros((len(wanted), 2), dtype=int)
        for seed in range(crops):
            crop = greenhouse(seed=100 + seed, plants=4, leaves=8, fruits=4)
            found = harvest.evaluate(_thinned(crop, gone), ROBOT, blockers=False)
            z = np.array([target.point[2] for target in crop.targets.values()])
            for k, (low, high) in enumerate(wanted):
                here = (z >= low) & (z < high)
                counts[k] += [int(here.sum()), int(found.decisions.ok[here].sum())]
        rows += [
            [gone, low, high, int(total), ok / max(1, total)]
            for (low, high), (total, ok) in zip(wanted, counts, strict=True)
        ]
    return rows


def _thinned(crop: Scene, gone: int) -> Scene:
    """Return a crop without the lowest leaves of each plant."""
    leaves: dict[str, list[tuple[float, str]]] = {}
    for one in crop.objects:
        if one.kind == "leaf":
            plant = one.name.split("_")[0]
            leaves.setdefault(plant, []).append((float(one.spheres[:, 2].mean()), one.name))
    names = [name for each in leaves.values() for _, name in sorted(each)[:gone]]
    return crop.without(*names)


MOTION_TIME = FIELD.motion
"""Motion of one attempt, assumed to be that of the paper, s."""
OTHER_TIME = FIELD.cycle - FIELD.motion
"""The rest of a cycle (driving, vision, gripping, cutting), assumed likewise, s."""
ATTEMPTS = 3


def field_cycle(
    scene_of: Callable[[int], Scene],
    *,
    crops: int = 6,
    vision: float = 0.010,
    tolerance: float = 0.010,
    seed: int = 1,
) -> dict[str, float]:
    """Simulate harvest cycles with errors of the vision system, at most three attempts a fruit.

    Each attempt plans for where the fruit is seen, a normal error away from where it is in
    each direction. It succeeds if there is a posture, if the arm keeps clear of the crop where
    it really is, and if the tool point is within the gripper's tolerance.

    Parameters
    ----------
    scene_of : callable
        Makes the crop of a number.
    crops : int, default 6
    vision : float, default 0.010, m
        Standard deviation of the vision error in each direction; assumed.
    tolerance : float, default 0.010, m
        What the gripper makes up for in each direction; assumed.
    seed : int, default 1

    Returns
    -------
    dict
        "fruits", "success" (share), "cycle" (s, of a successful attempt), "per_cucumber" (s,
        all attempts on fruits that were tried), "attempts" (mean of those tried), with the
        motion times of the paper.
    """
    rng = np.random.default_rng(seed)
    fruits = done = tries = tried = 0
    for number in range(crops):
        scene = scene_of(number)
        names = list(scene.targets)
        fruits += len(names)
        left = dict.fromkeys(names)
        for _ in range(ATTEMPTS):
            if not left:
                break
            errors = rng.normal(0, vision, (len(left), 3))
            seen = {
                name: _shifted(scene, name, error) for name, error in zip(left, errors, strict=True)
            }
            found = harvest.evaluate(_with_targets(scene, seen), ROBOT, blockers=False)
            ok = found.decisions.ok
            for k, name in enumerate(list(left)):
                if not ok[k]:
                    # Nothing is tried: the fruit is skipped at once.
                    left.pop(name)
                    continue
                tries += 1
                near = bool((np.abs(errors[k]) <= tolerance).all())
                free = scene.aiming_at(name).clearance(
                    Robot.load(ROBOT), found.decisions.q[k], own=False
                )
                if near and float(free) > 0:
                    done += 1
                    left.pop(name)
        tried = tries
    cycle = MOTION_TIME + OTHER_TIME
    return {
        "fruits": float(fruits),
        "success": done / max(1, fruits),
        "cycle": cycle,
        "per_cucumber": cycle * tried / max(1, done),
        "attempts": tried / max(1, done),
    }


def _shifted(scene: Scene, name: str, error: np.ndarray) -> Any:
    from ...collision import Target

    of = scene.targets[name]
    x, y, z = (float(a + b) for a, b in zip(of.point, error, strict=True))
    return Target((x, y, z), of.objects)


def _with_targets(scene: Scene, targets: dict[str, Any]) -> Scene:
    return Scene(scene.objects, targets=targets, exemptions=scene.exemptions)
