"""What ``agrik-fast info`` prints."""

from __future__ import annotations

import inspect
import math
import warnings
from collections.abc import Mapping, Sequence

import numpy as np

from .. import solvers
from .._files import brief
from .._names import solver_names
from ..collision import BodyShape, Box, Capsule, Convex, Cover, Sphere
from ..errors import AgrikError, ArgumentError
from ..robot import Robot
from ..rotations import quat_of
from ._exits import say
from ._tables import aligned

# Solvers without settings of their own.
_WITHOUT_CLASS = {"auto": "A closed form where the arm has one, and `lm` where that finds nothing."}


def list_robots() -> str:
    """Return the robots that have names, one a line, with their descriptions."""
    return _lines({name: _description(name) for name in Robot.names()})


def list_solvers() -> str:
    """Return the solvers, one a line, with the first sentence on each."""
    classes = [getattr(solvers, name) for name in solvers.__all__]
    known = {each.name: each for each in classes if hasattr(each, "name")}
    return _lines({name: _summary(known.get(name), name) for name in solver_names()})


def _summary(solver: type | None, name: str) -> str:
    if solver is None:
        return _WITHOUT_CLASS[name]
    return (inspect.getdoc(solver) or "").partition("\n")[0]


def _lines(words: Mapping[str, str]) -> str:
    width = max(map(len, words))
    return "\n".join(f"{name.ljust(width)}  {text}".rstrip() for name, text in words.items())


def _description(name: str) -> str:
    # A robot of another package may be broken; the list is there to say so.
    try:
        return Robot.load(name).description
    except AgrikError as error:
        return f"cannot be loaded: {brief(error)}"


def describe(robot: Robot, q: Sequence[float] | None = None) -> str:
    """Return a robot's joints, limits, reach, DH rows, frames and source as text.

    With joint values, rad or m, also the tool's pose there.
    """
    blocks = [
        f"{robot.name}: {robot.description}" if robot.description else robot.name,
        *(f"Note: {note}" for note in robot.notes),
        _joints(robot),
        _reach(robot),
    ]
    if q is not None:
        blocks.append(_pose(robot, q))
    if robot.dh is not None:
        blocks.append(_dh(robot))
    if robot.end_effector is not None:
        hand = robot.end_effector
        blocks.append(f"End effector\n  servo {hand.servo} moves {', '.join(hand.moves)}")
    if robot.frames:
        blocks.append(_frames(robot))
    if robot.source:
        lines = [f"  {key}: {value}" for key, value in robot.source.items() if value]
        blocks.append("\n".join(["Source", *lines]))
    if robot.provenance:
        blocks.append(_provenance(robot))
    return "\n\n".join(blocks)


def no_robot() -> ArgumentError:
    """Return the error of options that ask about a robot where there is none."""
    return ArgumentError("ROBOT", "none", "a robot, which the options are about")


def about_collisions(robot: Robot, *, body: bool, self_pairs: bool) -> str:
    """Return a robot's bodies, or its self pairs, as text; warnings about them first.

    Raises
    ------
    AgrikError
        For a mesh that is missing.
    """
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        known = robot.bodies
    for warning in told:
        say(f"agrik-fast: {warning.message}")
    if not known:
        return f"{robot.name} has no bodies"
    blocks = [_bodies(robot)] if body else []
    return "\n\n".join(blocks + ([_self_pairs(robot)] if self_pairs else []))


_SHAPE_NAMES = {
    Sphere: "sphere",
    Capsule: "capsule",
    Box: "box",
    Convex: "convex",
    Cover: "cover",
}


def _bodies(robot: Robot) -> str:
    links = ["base", *robot.link_names]
    rows = [["name", "frame", "shape", "size mm", "over mm", "from"]]
    for body in robot.bodies:
        over = "-" if body.overestimate is None else f"{1e3 * body.overestimate:.1f}"
        frame = links[robot.frame_number(body.frame)]
        shape = _SHAPE_NAMES[type(body.shape)]
        rows.append([body.name, frame, shape, _size(body.shape), over, body.provenance])
    # The last column is text of any length.
    told = [row[:-1] for row in rows]
    table = _table(f"Bodies of {robot.name} ({len(rows) - 1})", told).splitlines()
    heading = "over: how far a body reaches out of what it stands for, - where nobody said"
    return "\n".join(
        [table[0], f"  {heading}"]
        + [f"{line}  {row[-1]}".rstrip() for line, row in zip(table[1:], rows, strict=True)]
    )


def _size(shape: BodyShape) -> str:
    def mm(value: float) -> str:
        return f"{1e3 * value:.4g}"

    match shape:
        case Sphere():
            return f"r {mm(shape.radius)}"
        case Capsule():
            return f"length {mm(math.dist(shape.a, shape.b))}, r {mm(shape.radius)}"
        case Convex():
            return f"{len(shape.vertices)} corners, r {mm(shape.radius)}"
        case Cover():
            sides = " x ".join(mm(2 * half) for half in shape.half)
            return f"{sides}, {8**shape.level} spheres"
        case Box():
            rounding = f", r {mm(shape.radius)}" if shape.radius else ""
            return " x ".join(mm(2 * half) for half in shape.half) + rounding


def _self_pairs(robot: Robot) -> str:
    pairs = robot.self_pairs
    lines = [f"Pairs of bodies that are asked whether they hit each other ({len(pairs.asked)})"]
    lines += [f"  {a} - {b}" for a, b in pairs.asked]
    lines += ["", f"Pairs that are not ({len(pairs.excluded)})"]
    for pair in pairs.excluded:
        share = "" if pair.share is None else f", hitting in {pair.share:.1%} of 4,000 postures"
        lines.append(f"  {pair.bodies[0]} - {pair.bodies[1]}: {pair.reason}{share}")
    return "\n".join(lines)


def _table(title: str, rows: Sequence[Sequence[str]]) -> str:
    """Return a title and rows in columns, the first one left-aligned."""
    return "\n".join([title, *aligned(rows, indent="  ")])


def _joints(robot: Robot) -> str:
    rows = [["name", "type", "lower", "upper", "unit", "in degrees"]]
    limits = zip(robot.joint_names, robot.joint_types, robot.lower, robot.upper, strict=True)
    for name, kind, low, high in limits:
        if kind == "prismatic":
            rows.append([name, kind, f"{low:.4f}", f"{high:.4f}", "m", ""])
        elif math.isinf(low) or math.isinf(high):
            rows.append([name, kind, "-", "-", "rad", "any"])
        else:
            degrees = f"{math.degrees(low):.2f} .. {math.degrees(high):.2f}"
            rows.append([name, kind, f"{low:.4f}", f"{high:.4f}", "rad", degrees])
    return _table(f"Joints ({robot.dof})", rows)


def _reach(robot: Robot) -> str:
    x, y, z = (f"{low:.4f} .. {high:.4f}" for low, high in np.asarray(robot.reach_box).T.tolist())
    centre = ", ".join(f"{value:.4f}" for value in robot.reach_center)
    return "\n".join(
        [
            "Reach of the tool point, base frame (proven bounds)",
            f"  within {robot.reach_radius:.4f} m of ({centre}) m",
            f"  x {x} m, y {y} m, z {z} m",
        ]
    )


def _pose(robot: Robot, q: Sequence[float]) -> str:
    if len(q) != robot.dof:
        received = "1 number" if len(q) == 1 else f"{len(q)} numbers"
        raise ArgumentError("--q0", received, f"{robot.dof}, one a joint")
    T = robot.fk(q)
    x, y, z = (f"{value:.6f}" for value in T[:3, 3].tolist())
    qx, qy, qz, qw = (f"{value:.6f}" for value in quat_of(T).tolist())
    return "\n".join(
        [
            "Pose of the tool at these joint values, base frame",
            f"  x {x} m, y {y} m, z {z} m",
            f"  qx {qx}, qy {qy}, qz {qz}, qw {qw}",
        ]
    )


def _dh(robot: Robot) -> str:
    heading = ["row", "type", "a m", "alpha deg", "d m", "theta deg"]
    rows = [
        [
            row.name,
            row.type,
            f"{row.a:.5f}",
            f"{math.degrees(row.alpha):.3f}",
            f"{row.d:.5f}",
            f"{math.degrees(row.theta):.3f}",
        ]
        for row in robot.dh or ()
    ]
    title = f"Denavit-Hartenberg rows ({robot.convention}); a joint's value is added to theta or d"
    return _table(title, [heading, *rows])


def _frames(robot: Robot) -> str:
    lines = ["Named frames (transform from the base frame: rotation rows, then translation m)"]
    for name, pose in robot.frames.items():
        turn = " ".join(f"[{' '.join(f'{value:g}' for value in row)}]" for row in pose[:3, :3])
        shift = " ".join(f"{value:g}" for value in pose[:3, 3])
        lines.append(f"  {name}: {turn} | {shift}")
    return "\n".join(lines)


def _provenance(robot: Robot) -> str:
    marks = [f"  {mark} = {meaning}" for mark, meaning in robot.provenance_marks.items()]
    items = [f"  {number}: {origin}" for number, origin in robot.provenance.items()]
    return "\n".join(["Where the numbers are from", *marks, *items])
