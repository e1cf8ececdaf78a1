"""How many targets are solved, and how often an answer claims what is not so: docs/robustness.md.

    python benches/robustness.py --packages .venv-robots
    python benches/robustness.py --packages .venv-robots --rows 2000 -o page.md

Robots, tasks and kinds of targets, each judged by kinematics of its own (`robust/`). The URDFs are
those of the packages `example-robot-data` and `rtb-data`. Exit status 1 if anything false was
claimed or a goal was missed; the page is written all the same.
"""

from __future__ import annotations

import argparse
import shlex
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from robust import files, page, postures
from robust.building import (
    CONTINUOUS,
    PRISMATIC,
    REVOLUTE,
    Place,
    changed,
    from_places,
    library_arm,
    place_of,
)
from robust.chain import Arm, transform
from robust.measure import Measured, measure

import agrik_fast as ik

TASKS = ("pose", "position")
SOLVERS = ("lm", "auto")
PAGE = Path(__file__).resolve().parent.parent / "docs" / "robustness.md"
SCALED = ("puma560", "redundant7", "ur5", "cucumber")
"""Bundled arms that are scaled, put on rails and given long tools: one of each family."""

Pair = tuple[Arm, ik.Robot]


def main() -> int:
    options = _options()
    warnings.simplefilter("ignore")
    begin = time.perf_counter()
    measured: dict[str, list[Measured]] = {}
    for title, make in PARTS.items():
        if options.only and title not in options.only:
            continue
        measured[title] = []
        for each in make(options):
            measured[title].append(each)
            print(_line(title, each), flush=True)
    command = "benches/robustness.py " + " ".join(shlex.quote(a) for a in options.told)
    text = page.write(measured, command.strip(), time.perf_counter() - begin)
    options.output.write_text(text, encoding="utf-8")
    print(f"{options.output.name} written")
    return int(any(_short(title, each) for title, part in measured.items() for each in part))


def _short(title: str, each: Measured) -> bool:
    """Whether a measurement misses what is asked."""
    if each.faults.total():
        return True
    if title == "Out of reach":
        return each.solved > 0
    return each.share < (1.0 if title == "Gantries" else page.GOAL)


def _line(title: str, each: Measured) -> str:
    return (
        f"{title}: {each.arm}, {each.kind}, {each.task}, {each.solver}: {page.percent(each.share)} "
        f"of {each.rows:,}, {each.median_us:.3g} us, faults {dict(each.faults) or 'none'}"
    )


def _structured(options: argparse.Namespace) -> Iterator[Measured]:
    for name in ik.Robot.names():
        yield from _each(files.bundled(name), "structured", options.rows)
    for name, urdf in files.ROBOTS.items():
        pair = files.from_urdf(name, urdf, options.packages)
        yield from _each(pair, "structured", options.rows)


def _others(options: argparse.Namespace) -> Iterator[Measured]:
    for name in ik.Robot.names():
        pair = files.bundled(name)
        for kind in postures.KINDS:
            if kind != "structured":
                yield from _each(pair, kind, _share(options, 4))


def _scale(options: argparse.Namespace) -> Iterator[Measured]:
    rows = _share(options, 10)
    for name in SCALED:
        arm, _ = files.bundled(name)
        kinds = {
            "as it is": ({}, 1.0),
            "x 0.001": ({"factor": 1e-3}, 1e-3),
            "x 1000": ({"factor": 1e3}, 1e3),
            "rod of 0.3 m": ({"tool": 0.3}, 1.0),
            "rod of 3 m": ({"tool": 3.0}, 1.0),
            "rod of 30 m": ({"tool": 30.0}, 1.0),
            "on a rail of 1 m": ({"rail": 1.0}, 1.0),
            "on a rail of 1 km": ({"rail": 1e3}, 1.0),
        }
        # The same postures at every scale, so that the steps can be compared.
        rng = np.random.default_rng(7)
        q = postures.draw(arm, "random", rows, rng)
        for kind, (change, unit) in kinds.items():
            pair = _pair(changed(arm, **change))
            used = q * np.where(pair[0].turns, 1.0, unit) if "rail" not in change else None
            for task in TASKS:
                for solver in SOLVERS:
                    found = measure(*pair, "random", task, solver, rows, unit, used)
                    found.kind = kind
                    yield found


def _gantries(options: argparse.Namespace) -> Iterator[Measured]:
    axes = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    for wrist in (0, 1, 3):
        for travel in (1e-3, 1.0, 1e3, 3e3, 1e4):
            slides = [
                Place(PRISMATIC, axis=tuple(axis), lower=0.0, upper=travel)
                for axis in np.eye(3).tolist()
            ]
            # The hand is a tenth of the travel, but no longer than half a metre.
            hand = min(0.1 * travel, 0.5)
            turns = [Place(REVOLUTE, axis=axis, lower=-2.0, upper=2.0) for axis in axes[:wrist]]
            tool = transform(None, (0.0, 0.0, hand if wrist else 0.0))
            name = f"3 slides, {wrist} turning"
            arm = from_places([*slides, *turns], tool, np.eye(4), name, travel)
            yield from _each(_pair(arm), "random", _share(options, 10), f"{travel:g} m")


def _free(options: argparse.Namespace) -> Iterator[Measured]:
    rows = _share(options, 10)
    for name in ("puma560", "redundant7", "ur5"):
        arm, _ = files.bundled(name)
        for limit in (np.inf, 2 * np.pi, 1e4, 999999.0, 1e16):
            kind = "continuous" if np.isinf(limit) else f"+-{limit:g} rad"
            yield from _each(_pair(changed(arm, free=limit)), "random", rows, kind)
    arm, _ = files.bundled("puma560")
    for far in (999999.0, 1e16):
        cart = [
            Place(PRISMATIC, axis=(1.0, 0.0, 0.0), lower=-far, upper=far),
            Place(PRISMATIC, axis=(0.0, 1.0, 0.0), lower=-far, upper=far),
            Place(CONTINUOUS),
        ]
        upper = [place_of(joint) for joint in arm.joints]
        mobile = from_places([*cart, *upper], arm.end, np.eye(4), "cart and puma560", 1.0)
        yield from _each(_pair(mobile), "random", rows, f"+-{far:g} m")


def _beyond(options: argparse.Namespace) -> Iterator[Measured]:
    for name in ik.Robot.names():
        yield from _each(files.bundled(name), "out of reach", _share(options, 20))


PARTS: dict[str, Callable[[argparse.Namespace], Iterator[Measured]]] = {
    "Structured postures": _structured,
    "Other postures": _others,
    "Scale, tools and rails": _scale,
    "Gantries": _gantries,
    "No limits": _free,
    "Out of reach": _beyond,
}


def _each(pair: Pair, kind: str, rows: int, label: str | None = None) -> Iterator[Measured]:
    for task in TASKS:
        for solver in SOLVERS:
            found = measure(*pair, kind, task, solver, rows)
            found.kind = label or kind
            yield found


def _pair(arm: Arm) -> Pair:
    robot = library_arm(arm)
    return arm.ordered(robot.joint_names), robot


def _share(options: argparse.Namespace, parts: int) -> int:
    return max(options.rows // parts, 1)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--rows", type=int, default=20_000, help="structured targets of a measurement (%(default)s)"
    )
    parser.add_argument(
        "--packages",
        type=Path,
        default=Path(sys.prefix),
        help="folder below which the robots' packages are installed (default: this Python's)",
    )
    parser.add_argument("--only", action="append", choices=list(PARTS), help="this part alone")
    parser.add_argument(
        "-o", "--output", type=Path, default=PAGE, help="default docs/robustness.md"
    )
    options = parser.parse_args()
    if options.rows < 1:
        parser.error("--rows: expected at least 1")
    # What the page says of the command names no folder of this machine.
    options.told = [] if options.rows == 20_000 else ["--rows", str(options.rows)]
    for only in options.only or ():
        options.told += ["--only", only]
    return options


if __name__ == "__main__":
    sys.exit(main())
