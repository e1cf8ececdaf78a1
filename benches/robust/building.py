"""Arms built twice: for our own kinematics, and as the Python that builds them with the library."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import agrik_fast as ik

from .chain import Arm, Array, Joint, from_rpy, rotation, to_rpy, transform

REVOLUTE, CONTINUOUS, PRISMATIC = "revolute", "continuous", "prismatic"


@dataclass
class Place:
    """Where a joint sits: as a URDF says it."""

    kind: str
    xyz: Sequence[float] = (0.0, 0.0, 0.0)
    rpy: Sequence[float] = (0.0, 0.0, 0.0)
    axis: Sequence[float] = (0.0, 0.0, 1.0)
    lower: float = -np.inf
    upper: float = np.inf
    mimic: tuple[str, float, float] | None = None


def from_places(places: Sequence[Place], tool: Array, base: Array, kind: str, scale: float) -> Arm:
    """Make an arm of URDF joints; tool and base are given to the library as matrices."""
    joints = []
    for i, place in enumerate(places):
        before = transform(from_rpy(place.rpy), place.xyz)
        axis = np.asarray(place.axis, float)
        joints.append(
            Joint(
                f"j{i}",
                place.kind,
                base @ before if i == 0 else before,
                axis / np.linalg.norm(axis),
                place.lower,
                place.upper,
                place.mimic,
            )
        )
    code = f"arm = ik.Robot.from_urdf('''{urdf(places)}''')\n"
    if (base != np.eye(4)).any():
        code += f"arm = arm.with_base({base.tolist()})\n"
    if (tool != np.eye(4)).any():
        code += f"arm = arm.with_tool({tool.tolist()})\n"
    return Arm(kind, tuple(joints), tool, code, kind, scale)


def urdf(places: Sequence[Place]) -> str:
    """Write URDF text; every number is given in full."""
    lines = ['<robot name="r"><link name="l0"/>']
    for i, place in enumerate(places):
        lines.append(
            f'<joint name="j{i}" type="{place.kind}"><parent link="l{i}"/><child link="l{i + 1}"/>'
            f'<origin xyz="{_words(place.xyz)}" rpy="{_words(place.rpy)}"/>'
            f'<axis xyz="{_words(place.axis)}"/>'
        )
        if place.kind != CONTINUOUS:
            low, high = (_word(end) for end in (place.lower, place.upper))
            lines.append(f'<limit lower="{low}" upper="{high}" effort="1" velocity="1"/>')
        if place.mimic is not None:
            source, multiplier, offset = place.mimic
            lines.append(
                f'<mimic joint="{source}" multiplier="{_word(multiplier)}" '
                f'offset="{_word(offset)}"/>'
            )
        lines.append(f'</joint><link name="l{i + 1}"/>')
    return "\n".join([*lines, "</robot>"])


def _word(number: float) -> str:
    return repr(float(number))


def _words(numbers: Sequence[float]) -> str:
    return " ".join(_word(number) for number in numbers)


def from_dh(
    rows: Array,
    convention: str,
    kinds: Sequence[str],
    ends: Sequence[tuple[float, float]],
    tool: Array,
    base: Array,
    kind: str,
    scale: float,
) -> Arm:
    """Make an arm of DH rows (a, alpha, d, theta); fixed rows are part of what follows."""
    joints = []
    before = base
    for i, (a, alpha, d, theta) in enumerate(rows.tolist()):
        along = transform(rotation((0, 0, 1), theta), (0.0, 0.0, d))
        across = transform(rotation((1, 0, 0), alpha), (a, 0.0, 0.0))
        # The joint moves along and about z, as what `along` does: their order does not matter.
        first, then = (
            (np.eye(4), along @ across)
            if convention == "standard"
            else (
                across @ along,
                np.eye(4),
            )
        )
        before = before @ first
        if kinds[i] != "fixed":
            joints.append(Joint(f"q{i + 1}", kinds[i], before, np.array([0.0, 0.0, 1.0]), *ends[i]))
            before = np.eye(4)
        before = before @ then
    listed = [[float(low), float(high)] for low, high in ends]
    # Rows of joints that turn freely are ignored; the library wants finite numbers there.
    listed = [
        [0.0, 0.0] if kinds[i] in (CONTINUOUS, "fixed") else pair for i, pair in enumerate(listed)
    ]
    code = (
        f"arm = ik.Robot.from_dh({rows.tolist()}, {convention!r}, limits={_list(listed)},\n"
        f"    joint_types={list(kinds)}, base={base.tolist()}, tool={tool.tolist()})\n"
    )
    return Arm(kind, tuple(joints), before @ tool, code, kind, scale)


def _list(pairs: list[list[float]]) -> str:
    return repr(pairs).replace("inf", 'float("inf")')


def changed(
    arm: Arm,
    factor: float = 1.0,
    free: float | None = None,
    rail: float | None = None,
    tool: float | None = None,
) -> Arm:
    """Return an arm like another one, to be built by the library.

    Parameters
    ----------
    arm : Arm
        The other one.
    factor : float
        By which all lengths are multiplied.
    free : float, optional
        Limits of all joints that turn become plus and minus this, rad; infinity: continuous.
    rail : float, optional
        Travel of a rail below the arm, m.
    tool : float, optional
        Length of a rod on the tool, along its z, m.
    """
    named = {joint.name: f"j{i + (rail is not None)}" for i, joint in enumerate(arm.joints)}
    places = [] if rail is None else [Place(PRISMATIC, axis=(0.0, 1.0, 0.0), lower=0.0, upper=rail)]
    for joint in arm.joints:
        place = place_of(joint)
        place.xyz = (factor * joint.before[:3, 3]).tolist()
        if joint.kind == PRISMATIC:
            place.lower, place.upper = factor * joint.lower, factor * joint.upper
        elif free is not None:
            place.kind = CONTINUOUS if np.isinf(free) else REVOLUTE
            place.lower, place.upper = -free, free
        if joint.mimic is not None:
            source, multiplier, offset = joint.mimic
            offset *= factor if joint.kind == PRISMATIC else 1.0
            place.mimic = (named[source], multiplier, offset)
        places.append(place)
    end = arm.end.copy()
    end[:3, 3] *= factor
    if tool is not None:
        end = end @ transform(None, (0.0, 0.0, tool))
    return from_places(places, end, np.eye(4), arm.name, factor * arm.scale)


def place_of(joint: Joint) -> Place:
    """A joint of an arm that was drawn, to stand on something else."""
    point, axis = joint.before[:3, 3].tolist(), joint.axis.tolist()
    rpy = to_rpy(joint.before[:3, :3])
    return Place(joint.kind, point, rpy, axis, joint.lower, joint.upper)


def library_arm(arm: Arm) -> ik.Robot:
    """Build the arm with the library, from the same text that a report shows."""
    names: dict[str, Any] = {"ik": ik}
    exec(compile(arm.code, "<arm>", "exec"), names)
    robot = names["arm"]
    assert isinstance(robot, ik.Robot)
    return robot
