"""Tasks: what counts as reaching a target.

A task says which parts of the tool's pose must meet the target. Pass one to
`Robot.ik` as an object or, with its defaults, by its name.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, TypeAlias

import numpy as np

from ._checks import direction, float_array, shown, word
from .errors import ArgumentError

__all__ = ["Axis", "Masked", "Pose", "Position", "PositionFirst", "SecondAim", "Task"]


@dataclass(frozen=True, slots=True)
class Position:
    """The tool point is at the target; the orientation is free (3 rows).

    Targets have shape (..., 3), m, or (..., 4, 4), of which the translation counts.

    Examples
    --------
    >>> arm = ik.Robot.load("ur5")
    >>> bool(arm.ik([0.4, 0.2, 0.3], task=ik.tasks.Position()).success)
    True
    """

    name: ClassVar[str] = "position"


@dataclass(frozen=True, slots=True)
class Pose:
    """The tool frame coincides with the target frame (6 rows).

    Targets are rigid transforms of shape (..., 4, 4), lengths in m. The orientation
    error is the rotation vector between tool and target, exact up to pi.

    Examples
    --------
    >>> arm = ik.Robot.load("ur5")
    >>> bool(arm.ik(arm.fk(np.full(6, 0.5)), task=ik.tasks.Pose()).success)
    True
    """

    name: ClassVar[str] = "pose"


@dataclass(frozen=True, slots=True)
class Axis:
    """The tool point is at the target and one tool axis is parallel to a direction (5 rows).

    The tool may turn freely about that axis.

    Parameters
    ----------
    tool_axis : tuple of 3 float, default (0, 0, 1)
        Axis in the tool frame, of any length but zero; kept as a unit vector.
    direction : tuple of 3 float, optional
        Direction in the base frame that the axis must point to, of any length but
        zero; kept as a unit vector. Needed for targets of shape (..., 3). For
        targets of shape (..., 4, 4) it defaults to the target's own `tool_axis`,
        ``R @ tool_axis``.

    Raises
    ------
    ArgumentError
        A direction is not three finite numbers, or zero.

    Examples
    --------
    The cucumber gripper, tool x pointing down:

    >>> from agrik_fast.tasks import Axis
    >>> Axis(tool_axis=(1, 0, 0), direction=(0, 0, -1))
    Axis(tool_axis=(1.0, 0.0, 0.0), direction=(0.0, 0.0, -1.0))
    """

    name: ClassVar[str] = "axis"
    tool_axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    direction: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "tool_axis", direction("Axis.tool_axis", self.tool_axis))
        if self.direction is not None:
            object.__setattr__(self, "direction", direction("Axis.direction", self.direction))


@dataclass(frozen=True, slots=True)
class Masked:
    """A pose of which each of the six error rows has a weight (0 leaves it free).

    Targets have shape (..., 4, 4), lengths in m.

    Parameters
    ----------
    weights : tuple of 6 float
        Weights >= 0 of the errors along x, y, z (m) and about x, y, z (rad), no unit;
        at least one above 0. The tolerances apply to the unweighted errors of the rows
        whose weight is above 0. For rows that are to be met within a margin of their own see
        `position_tolerance` and `orientation_tolerance` of `Robot.ik`.
    frame : {"base", "tool"}, default "base"
        Frame in which the rows are counted.

    Raises
    ------
    ArgumentError
        Not six finite weights >= 0, all zero, or another frame.

    Examples
    --------
    Position and heading, roll and pitch free:

    >>> from agrik_fast.tasks import Masked
    >>> Masked((1, 1, 1, 0, 0, 1)).frame
    'base'
    """

    name: ClassVar[str] = "masked"
    weights: tuple[float, float, float, float, float, float]
    frame: Literal["base", "tool"] = "base"

    def __post_init__(self) -> None:
        weights = float_array("Masked.weights", self.weights)
        if weights.shape != (6,):
            raise ArgumentError("Masked.weights", f"shape {weights.shape}", "shape (6,)")
        if not (np.isfinite(weights).all() and (weights >= 0).all() and weights.any()):
            raise ArgumentError(
                "Masked.weights",
                str(weights.tolist()),
                "finite weights >= 0, at least one above 0",
            )
        frame: object = self.frame
        if not isinstance(frame, str) or frame not in ("base", "tool"):
            raise ArgumentError("Masked.frame", repr(self.frame), "'base' or 'tool'")
        object.__setattr__(self, "weights", tuple(weights.tolist()))


@dataclass(frozen=True, slots=True)
class PositionFirst:
    """The tool point is at the target, exactly; its orientation as near as that allows.

    Targets have shape (..., 4, 4), lengths in m. A target counts as solved where the
    position is within its tolerance; `IkResult.orientation_error` says how far the tool's
    orientation is from the target's, which is the least that a search from several starts
    finds. An orientation within `orientation_tolerance` ends the search.

    For step solvers other than feedback laws (which go on with their own steps and are
    judged by the position), and for population solvers. Of the closed forms, "auto" leaves
    such targets to "lm".

    Examples
    --------
    A 5-axis arm, which has no full pose to spare:

    >>> from agrik_fast.tasks import PositionFirst
    >>> PositionFirst.name
    'position-first'
    """

    name: ClassVar[str] = "position-first"


Task: TypeAlias = Position | Pose | Axis | Masked | PositionFirst
"""Any task."""


@dataclass(frozen=True, slots=True)
class SecondAim:
    """What the freedom is used for that a target leaves to an arm.

    Of the postures that reach the target the best one nearby by a measure: answers are moved in
    the null space of the task to a local optimum within the limits, and stay answers. Pass one
    as `second_aim`, or its measure as a word.

    Parameters
    ----------
    measure : {"near", "middle", "limits", "manipulability"}
        "near": the least sum of ``w (q - posture)^2``. "middle": the least sum of
        ``w ((q - middle) / half range)^2``; joints without limits count nothing. "limits": the
        least sum of ``w (u - l)^2 / (4 (u - q) (q - l))``, which grows without bound at a limit
        (Chan and Dubey 1995, eq. 8). "manipulability": the greatest ``det(J J^T)`` (Yoshikawa
        1985), of the tool point, and of its turns too for full poses of six joints or more.
    posture : array_like, shape (n,), rad or m, optional
        For "near". Default: `q0`, or the middle of the limits without it.
    weights : array_like, shape (n,), optional
        Weight of each joint, 0 or more; not for "manipulability". Default: 1 each.

    Raises
    ------
    ArgumentError
        Numbers that are not finite or weights below 0; a posture for another measure than
        "near"; weights for "manipulability".
    UnknownNameError
        An unknown measure.

    Examples
    --------
    >>> from agrik_fast.tasks import SecondAim
    >>> SecondAim("near", posture=(0, 0.5, 0, -1.5, 0, 2, 0.7), weights=(1, 1, 1, 1, 0.1, 0.1, 0.1))
    SecondAim('near')
    """

    MEASURES: ClassVar[tuple[str, ...]] = ("near", "middle", "limits", "manipulability")

    measure: str
    posture: tuple[float, ...] | None = None
    weights: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        word("second_aim", self.measure, self.MEASURES)
        for name in ("posture", "weights"):
            value = getattr(self, name)
            if value is not None:
                place = f"SecondAim.{name}"
                array = float_array(place, value)
                if array.ndim != 1 or not np.isfinite(array).all():
                    raise ArgumentError(place, shown(value), "finite numbers, one a joint")
                object.__setattr__(self, name, tuple(array.tolist()))
        if self.posture is not None and self.measure != "near":
            raise ArgumentError("SecondAim.posture", "a posture", "none but for 'near'")
        if self.weights is not None:
            if self.measure == "manipulability":
                raise ArgumentError("SecondAim.weights", "weights", "none for 'manipulability'")
            if min(self.weights, default=0) < 0 or not any(self.weights):
                raise ArgumentError(
                    "SecondAim.weights", shown(self.weights), "numbers 0 or more, not all 0"
                )

    def __repr__(self) -> str:
        return f"SecondAim({self.measure!r})"
