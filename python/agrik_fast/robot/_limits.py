"""Other limits of an arm's joints, and joints that stand still: for good, or for a call."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Self, cast

import numpy as np
from numpy.typing import ArrayLike

from .. import _native
from .._checks import FloatArray, float_array, real_number, shown, word
from .._records import made, to_dict
from ..errors import ArgumentError
from ._definition import Definition

if TYPE_CHECKING:
    from ..result import IkResult

__all__ = ["JointLimits", "in_the_core", "limits_of_rows", "with_limits_of_rows"]

#: Solvers to which the core gives limits of each row.
STEPS = frozenset(_native.limited_solver_names())


class JointLimits:
    """The part of `Robot` that makes arms of other limits, or with joints locked."""

    __slots__ = ()

    if TYPE_CHECKING:
        _chain: _native.Chain
        _definition: Definition
        _with: Callable[[Definition], Self]

        @property
        def joint_names(self) -> tuple[str, ...]: ...

        @property
        def lower(self) -> FloatArray: ...

        @property
        def upper(self) -> FloatArray: ...

    def with_limits(self, limits: Mapping[str, ArrayLike] | ArrayLike) -> Self:
        """Return the same robot with other joint limits.

        Parameters
        ----------
        limits : mapping of str to (lower, upper), or array_like, shape (n, 2), rad or m
            Smallest and largest values by joint name; joints that are not named keep theirs. Or
            those of all joints in the order of q, where NaN keeps the robot's. A joint without
            limits gets some, and infinite ones make an angle turn freely.

        Returns
        -------
        Robot
            The new robot.

        Raises
        ------
        UnknownNameError
            No joint has that name.
        ArgumentError
            A wrong shape, or a lower limit above the upper one.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> arm = Robot.load("ur5").with_limits({"elbow": (-2.5, 2.5)})
        >>> arm.upper[2].item(), arm.lower[2].item()
        (2.5, -2.5)
        """
        table = np.stack([self.lower, self.upper], axis=1)
        if isinstance(limits, Mapping):
            for name, pair in limits.items():
                word("joint", name, self.joint_names)
                both = float_array(f"limits[{name!r}]", pair)
                if both.shape != (2,) or np.isnan(both).any():
                    raise ArgumentError(f"limits[{name!r}]", shown(pair), "two numbers")
                table[self.joint_names.index(name)] = both
        else:
            given = float_array("limits", limits)
            if given.shape != table.shape:
                expected = f"shape {table.shape}, or limits by joint name"
                raise ArgumentError("limits", f"shape {given.shape}", expected)
            table = np.where(np.isnan(given), table, given)
        for name, (lower, upper) in zip(self.joint_names, table.tolist(), strict=True):
            if lower > upper or (lower == upper and math.isinf(lower)):
                expected = "lower <= upper, and a number that keeps both"
                raise ArgumentError(f"limits[{name!r}]", f"({lower}, {upper})", expected)
        new = {
            name: (row[0], row[1])
            for name, row in zip(self.joint_names, table.tolist(), strict=True)
        }
        rows = self._definition.dh
        if rows is not None:
            rows = tuple(
                row._replace(lower=new[row.name][0], upper=new[row.name][1])
                if row.name in new
                else row
                for row in rows
            )
        return self._with(self._definition.replaced(limits=self._definition.limits | new, dh=rows))

    def lock(self, joints: Mapping[str, float]) -> Self:
        """Return the arm that is left when some joints stand still.

        Parameters
        ----------
        joints : mapping of str to float
            Values of the joints by name, within their limits, rad or m.

        Returns
        -------
        Robot
            An arm without these joints in q; those that are left keep their order. Links,
            frames and bodies stay.

        Raises
        ------
        UnknownNameError
            No joint has that name.
        ArgumentError
            A value outside of the joint's limits, or no joint is left.

        Examples
        --------
        >>> from agrik_fast import Robot
        >>> six = Robot.load("panda").lock({"panda_joint3": 0.3})
        >>> six.dof, six.joint_names[2]
        (6, 'panda_joint4')
        """
        if not isinstance(joints, Mapping):
            raise ArgumentError("joints", shown(joints), "values by joint name")
        locked = {}
        for name, value in joints.items():
            word("joint", name, self.joint_names)
            at = self.joint_names.index(name)
            number = real_number(f"joints[{name!r}]", value)
            if not self.lower[at] <= number <= self.upper[at]:
                expected = f"a value within the limits, {self.lower[at]:g} to {self.upper[at]:g}"
                raise ArgumentError(f"joints[{name!r}]", f"{number:g}", expected)
            locked[name] = number
        if len(locked) == len(self.joint_names):
            raise ArgumentError("joints", "all joints", "at least one that is left to move")
        if not locked:
            return self._with(self._definition)
        home = {k: v for k, v in self._definition.home.items() if k not in locked}
        changes: dict[str, Any] = {"locks": self._definition.locks | locked, "home": home}
        return self._with(self._definition.replaced(dh=None, convention=None, **changes))


def limits_of_rows(
    arm: JointLimits, targets: ArrayLike, limits: ArrayLike
) -> tuple[FloatArray, tuple[int, ...] | None]:
    """Return limits with NaN made the arm's own; if of each row, with the rows' shape."""
    dof = len(arm.joint_names)
    table = float_array("limits", limits)
    own = np.stack([arm.lower, arm.upper], axis=1)
    if table.shape[-2:] != (dof, 2):
        expected = f"({dof}, 2), or one that broadcasts to (..., {dof}, 2)"
        raise ArgumentError("limits", f"shape {table.shape}", f"shape {expected}")
    table = np.where(np.isnan(table), own, table)
    if table.ndim == 2:
        return table, None
    shape = np.shape(targets)
    leading = shape[: -2 if shape[-2:] == (4, 4) else -1]
    try:
        return np.broadcast_to(table, (*leading, dof, 2)), leading
    except ValueError:
        expected = f"one that broadcasts to {(*leading, dof, 2)}"
        raise ArgumentError("limits", f"shape {np.shape(limits)}", expected) from None


def in_the_core(solver: object, scene: object, second_aim: object, nearest: object) -> bool:
    """Return whether limits of each row are left to the core: its solvers, and no other wish."""
    name = solver if isinstance(solver, str) else getattr(solver, "name", "")
    # A scene without objects is false, and yet a wish: the arm's own bodies.
    return name in STEPS and scene is None and second_aim is None and not nearest


def with_limits_of_rows(
    solve: Callable[..., IkResult],
    arm: JointLimits,
    targets: ArrayLike,
    table: FloatArray,
    leading: tuple[int, ...] | None,
    **options: Any,
) -> IkResult:
    """Solve targets within limits of the call, or of rows of a shape, by `Robot.ik`."""
    if leading is None:
        return solve(arm.with_limits(table), targets, **options)
    dof = len(arm.joint_names)
    table = table.reshape(-1, dof, 2)
    goals = float_array("targets", targets)
    goals = goals.reshape(-1, *goals.shape[len(leading) :])
    q0, first = options.pop("q0"), options.pop("first_index")
    if q0 is not None:
        q0 = np.broadcast_to(float_array("q0", q0), (*leading, dof)).reshape(-1, dof)
    # Rows with the same limits are solved together, by the streams of their own indices.
    fields: dict[str, Any] = {}
    distinct, which = np.unique(table, axis=0, return_inverse=True)
    for number, pair in enumerate(distinct):
        rows = np.flatnonzero(which.reshape(-1) == number)
        goal = goals
        try:
            solving = arm.with_limits(pair)
        except ArgumentError:  # limits that no value keeps
            solving, goal = arm, np.full_like(goals, np.nan)
        # Where rows do not follow one another each is a call of its own.
        runs = np.split(rows, np.flatnonzero(np.diff(rows) != 1) + 1)
        for run in runs:
            part = solve(
                solving,
                goal[run],
                q0=None if q0 is None else q0[run],
                first_index=first + int(run[0]),
                **options,
            )
            for name, array in to_dict(part).items():
                if name not in fields:
                    fields[name] = np.zeros((len(goals), *array.shape[1:]), array.dtype)
                fields[name][run] = array
    shaped = {name: array.reshape(*leading, *array.shape[1:]) for name, array in fields.items()}
    return cast("IkResult", made("IkResult", shaped))
