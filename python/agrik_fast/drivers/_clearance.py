"""Whether the strawberry arm stays clear of plant and bed on its way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .._checks import FloatArray, finite_array, real_number
from ..arms import StrawberryArm
from ._errors import ClearanceError

__all__ = ["Surroundings"]

PARTS = ("column", "upper link", "gripper")

# Between two postures that are looked at, no point of the arm moves further.
_STEP_M = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """What stands round the arm, in its base frame, m.

    Parameters
    ----------
    plant_centre : tuple of float, m
        Centre of the sphere that the plant fills; that of the paper's table 3.
    plant_radius : float, m
        Its radius.
    bed_top : float, m
        Height of the raised bed's upper side; its size is assumed.
    bed_half_width : float, m
        Half its width, along y, about the plant's centre.
    arm_radius : float, m
        Half the thickness of column and upper link; assumed.
    give : float, m
        How deep gripper and upper link may be among leaves while the arm comes down to a fruit
        or leaves it: fruits low on the plant cannot be had otherwise. Assumed.

    Raises
    ------
    ArgumentError
        A number is out of its range.

    Examples
    --------
    >>> from agrik_fast.drivers import Surroundings
    >>> around = Surroundings(plant_radius=0.12)
    >>> around.bed_top
    -0.495
    """

    plant_centre: tuple[float, float, float] = (0.5, 0.3675, -0.395)
    plant_radius: float = 0.1
    bed_top: float = -0.495
    bed_half_width: float = 0.15
    arm_radius: float = 0.01
    give: float = 0.025

    def __post_init__(self) -> None:
        finite_array("Surroundings.plant_centre", self.plant_centre, (3,))
        for name in ("plant_radius", "bed_half_width", "arm_radius", "give"):
            real_number(f"Surroundings.{name}", getattr(self, name), 0, unit="m")
        real_number("Surroundings.bed_top", self.bed_top, unit="m")

    def _depths(self, arm: StrawberryArm, q: FloatArray) -> dict[tuple[str, str], FloatArray]:
        """Return how deep each part is in each obstacle, m; negative where it is clear of it.

        Parameters
        ----------
        arm : StrawberryArm
            The arm.
        q : ndarray, shape (n, 5), m and rad
            Postures.

        Returns
        -------
        dict
            By part and obstacle, arrays of shape (n,).
        """
        points = link_points(arm, q)
        centre = np.array(self.plant_centre)
        found = {}
        for number, part in enumerate(PARTS):
            thick = self.arm_radius if part != "gripper" else 0.0
            start, end = points[:, number], points[:, number + 1]
            apart = _distance(centre, start, end)
            found[part, "plant"] = self.plant_radius + thick - apart
            # The lowest point of a straight part is one of its ends.
            ends = np.stack([start, end], axis=1)
            above = ends[..., 2] - thick - self.bed_top
            beside = np.abs(ends[..., 1] - centre[1]) - self.bed_half_width - thick
            found[part, "bed"] = -np.maximum(above, beside).min(axis=1)
        return found

    def check_way(
        self,
        arm: StrawberryArm,
        postures: Sequence[FloatArray],
        names: Sequence[str],
        gentle: Sequence[bool],
    ) -> None:
        """Refuse a way that touches something.

        Parameters
        ----------
        arm : StrawberryArm
            The arm.
        postures : sequence of ndarray, shape (5,), m and rad
            Corners of the way; between them joint values change in proportion.
        names : sequence of str
            What each step is called, one fewer than there are postures.
        gentle : sequence of bool
            On which steps gripper and upper link may be among leaves.

        Raises
        ------
        ClearanceError
            Names the pair, the step and the depth.

        Examples
        --------
        >>> from agrik_fast.drivers import Surroundings
        >>> from agrik_fast.arms import StrawberryArm
        >>> arm = StrawberryArm()
        >>> way = [arm.solve([0.426, 0.345, z]).q for z in (-0.25, -0.3316)]
        >>> Surroundings().check_way(arm, way, ["above", "down"], [False, True])
        """
        for name, soft, start, end in zip(names, gentle, postures, postures[1:], strict=False):
            found = self._touch(arm, start, end, soft)
            if found is not None:
                (part, obstacle), depth = found
                raise ClearanceError(part, obstacle, name, depth)

    def _touch(
        self, arm: StrawberryArm, start: FloatArray, end: FloatArray, soft: bool
    ) -> tuple[tuple[str, str], float] | None:
        # Pitch and roll turn the whole arm, whose reach is l2 + l3.
        lengths = [float(np.asarray(arm.parameters[name])) for name in ("l2", "l3")]
        off = np.abs(end - start)
        way = float(off[:3].sum() + sum(lengths) * off[3] + lengths[1] * off[4])
        count = max(math.ceil(way / _STEP_M), 1) + 1
        share = np.linspace(0.0, 1.0, count)[:, None]
        depths = self._depths(arm, start + share * (end - start))
        worst: tuple[tuple[str, str], float] | None = None
        for pair, depth in depths.items():
            among_leaves = soft and pair in (("gripper", "plant"), ("upper link", "plant"))
            allowed = self.give if among_leaves else 0.0
            deepest = float(depth.max())
            if deepest > allowed + _STEP_M / 2 and (worst is None or deepest > worst[1]):
                worst = pair, deepest
        return worst


def link_points(arm: StrawberryArm, q: FloatArray) -> FloatArray:
    """Return rail, pitch axis, roll axis and tool point, shape (n, 4, 3), m."""
    l2, l3 = (float(np.asarray(arm.parameters[name])) for name in ("l2", "l3"))
    theta, beta = q[:, 3], q[:, 4]
    zero = np.zeros_like(theta)
    down = np.stack([-np.sin(theta), zero, -np.cos(theta)], axis=1)
    across = np.stack([zero, np.sin(beta), zero], axis=1)
    tip = arm.fk(q)
    roll = tip - l3 * (np.cos(beta)[:, None] * down + across)
    pitch = roll - l2 * down
    rail = pitch + np.stack([zero, zero, q[:, 2]], axis=1)
    return np.stack([rail, pitch, roll, tip], axis=1)


def _distance(point: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return distances of a point from segments."""
    along = end - start
    square = np.maximum((along**2).sum(axis=1), 1e-30)
    share = np.clip(((point - start) * along).sum(axis=1) / square, 0.0, 1.0)
    return np.asarray(np.linalg.norm(point - start - share[:, None] * along, axis=1))
