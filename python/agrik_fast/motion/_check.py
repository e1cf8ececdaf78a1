"""Whether an arm is free on its whole way: proofs between postures, not samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _native
from .._checks import FloatArray, finite_array, float_array, shown
from ..collision import Scene
from ..errors import ArgumentError
from ..robot import JointPath, Robot

__all__ = ["Checked", "Contact", "Outcome", "check", "check_segments"]


class Outcome(IntEnum):
    """What is known of a way.

    Examples
    --------
    >>> from agrik_fast.motion import Outcome
    >>> [each.name for each in Outcome][:2]
    ['SAFE', 'HIT']
    """

    SAFE = 0
    """It is free, and that is proven."""
    HIT = 1
    """A posture of it is too near to something."""
    UNDECIDED = 2
    """Neither was found: it grazes what it must not touch, or questions ran out. Not safe."""


@dataclass(frozen=True, eq=False)
class Contact:
    """A body that is too near to something, or what is nearest.

    Attributes
    ----------
    body, other : str
        Names of the body, and of the object or the other body of the arm.
    is_own : bool
        The other one is a body of the arm.
    distance : float, m
        Of the two from each other; 0 or less in contact.
    points : ndarray, shape (2, 3), m
        Where they come nearest: the body's point and the other's.

    Examples
    --------
    >>> from agrik_fast.motion import check
    >>> from agrik_fast.collision import Capsule, SceneObject
    >>> arm = ik.Robot.load("panda")
    >>> scene = ik.Scene([SceneObject.of("post", Capsule([0.5, 0, 0], [0.5, 0, 1], 0.05))])
    >>> start, goal = [-1, 0, 0, -1.5, 0, 1.5, 0], [1, 0, 0, -1.5, 0, 1.5, 0]
    >>> check(arm, [start, goal], scene).contact.other
    'post'
    """

    body: str
    other: str
    is_own: bool
    distance: float
    points: FloatArray


@dataclass(frozen=True, eq=False)
class Checked:
    """What is known of the pieces of a path, or of many ways.

    Attributes
    ----------
    q : ndarray, shape (n, dof), rad or m
        The waypoints; of ways, where they begin.
    outcome : ndarray of uint8, shape (m,)
        Codes of `Outcome`, one a piece; of a path of one waypoint that of the posture.
    clearance : ndarray, shape (m,), m
        Distance that is kept all along a safe piece, of bodies from the scene and from each
        other; never more than the true one, and no more than ``cap``. 0 where it is not safe.
    at : ndarray, shape (m,)
        Where a piece is not safe, how far along it that was found, 0 to 1.
    checks : ndarray of int, shape (m,)
        Questions asked: one a body or a pair of bodies at one posture.
    contacts : tuple of m (Contact or None)
        What is too near there; None for safe pieces.
    within_limits : bool
        All joint values are within the limits, those between as well.

    Examples
    --------
    >>> from agrik_fast.motion import check
    >>> arm = ik.Robot.load("panda")
    >>> start, goal = [-1, 0, 0, -1.5, 0, 1.5, 0], [1, 0, 0, -1.5, 0, 1.5, 0]
    >>> check(arm, [start, goal], ik.Scene([])).safe
    True
    """

    q: FloatArray
    outcome: NDArray[np.uint8]
    clearance: FloatArray
    at: FloatArray
    checks: NDArray[np.int64]
    contacts: tuple[Contact | None, ...]
    within_limits: bool
    _to: FloatArray

    @property
    def safe(self) -> bool:
        """All of it is proven free."""
        return bool((self.outcome == Outcome.SAFE).all())

    @property
    def status(self) -> Outcome:
        """The outcome of all together: the first that is not safe, a hit before the rest."""
        for outcome in (Outcome.HIT, Outcome.UNDECIDED):
            if (self.outcome == outcome).any():
                return outcome
        return Outcome.SAFE

    @property
    def certified(self) -> float:
        """Distance that is kept all along the path, m; 0 where it is not safe."""
        return float(self.clearance.min()) if len(self.clearance) else 0.0

    @property
    def segment(self) -> int:
        """Which piece is the first that hits, or else is not safe; -1 for none."""
        found = np.flatnonzero(self.outcome == self.status)
        return int(found[0]) if self.status != Outcome.SAFE else -1

    @property
    def contact(self) -> Contact | None:
        """What is too near there."""
        return self.contacts[self.segment] if self.segment >= 0 else None

    @property
    def witness(self) -> FloatArray | None:
        """The posture there, shape (dof,), rad or m."""
        k = self.segment
        if k < 0:
            return None
        return np.asarray(self.q[k] + self.at[k] * (self._to[k] - self.q[k]))

    def __repr__(self) -> str:
        said = f"Checked({len(self.outcome)} pieces, {self.status.name}"
        if self.safe:
            return f"{said}, {1e3 * self.certified:.1f} mm)"
        contact = self.contact
        near = f": {contact.body} and {contact.other}" if contact else ""
        return f"{said} in piece {self.segment}{near})"


def check(
    arm: Robot,
    path: ArrayLike | Any,
    scene: Scene | None = None,
    *,
    clear: float = 0.0,
    own_clear: float | None = None,
    cap: float | None = None,
    tolerance: float = 1e-5,
    max_checks: int = 100_000,
    threads: int | None = None,
) -> Checked:
    """Prove that an arm is free all along a path, wherever the path comes from.

    Between its waypoints the path is straight in joint space. At a posture a body keeps a
    distance; on the way it moves no farther than its levers and the rates of the joints
    allow; where the second is less than the first, nothing is met. What is left is cut and
    asked again. So a piece is proven safe, or shown to hit, or stays undecided where it grazes.

    Parameters
    ----------
    arm : Robot
        An arm with bodies.
    path : array_like, shape (n, dof), rad or m
        Waypoints, one or more; or something with such an array as ``q`` or ``path``, as
        `Robot.follow` and `plan` return. Of a `JointPath` the rounded corners count as well: a
        piece whose corner is not proven is undecided.
    scene : Scene, optional
        What stands round it; default nothing but the arm itself. Where it aims at a target, that
        may be touched while the tool point is near it.
    clear : float, default 0, m
        Distance to be kept from the scene: as near or nearer is a hit.
    own_clear : float, optional, m
        The same between bodies of the arm. Default: `clear`, and 2 mm at most.
    cap : float, optional, m
        Distances above it are not told; the less it is, the quicker. Default: none.
    tolerance : float, default 1e-5, m
        Pieces on which bodies move no farther are not cut again.
    max_checks : int, default 100000
        Most questions for a piece.
    threads : int, optional
        Number of threads, as for `Robot.ik`. Answers do not depend on it.

    Returns
    -------
    Checked

    Raises
    ------
    ArgumentError
        A wrong shape, a number that is not finite or out of its range, an arm without bodies
        (says what to add); an exemption of a body that the arm does not have.

    Notes
    -----
    The midpoint rule goes back to Schwarzer, Saha and Latombe, "Adaptive dynamic collision
    checking for single and multiple articulated robots in complex environments", IEEE
    Transactions on Robotics 21 (2005).

    Examples
    --------
    >>> from agrik_fast import Robot, motion
    >>> from agrik_fast.collision import Scene, SceneObject, Sphere
    >>> arm = Robot.load("panda")
    >>> ball = SceneObject.of("ball", Sphere([0.5, 0, 0.5], 0.1))
    >>> path = [[-1, 0, 0, -1.5, 0, 1.5, 0], [1, 0, 0, -1.5, 0, 1.5, 0]]
    >>> found = motion.check(arm, path, Scene([ball]))
    >>> found.status.name, found.contact.other
    ('HIT', 'ball')
    >>> motion.check(arm, path).safe
    True
    """
    q = waypoints(path, checked_arm(arm).dof)
    options = options_of(clear, own_clear, cap, tolerance, max_checks)
    collider = scene_of(scene).collider(arm)
    columns = _native.motion_check(collider, q, None, options, threads)
    to = q if len(q) == 1 else q[1:]
    if isinstance(path, JointPath):
        _add_corners(columns, collider, path, options, threads)
    return _checked(arm, collider, q, to, columns)


def check_segments(
    arm: Robot,
    start: ArrayLike,
    end: ArrayLike,
    scene: Scene | None = None,
    *,
    clear: float = 0.0,
    own_clear: float | None = None,
    cap: float | None = None,
    tolerance: float = 1e-5,
    max_checks: int = 100_000,
    threads: int | None = None,
) -> Checked:
    """Prove for many straight ways that an arm is free on them; `check` says how.

    Parameters
    ----------
    arm, scene, clear, own_clear, cap, tolerance, max_checks, threads
        As for `check`.
    start, end : array_like, shape (m, dof), rad or m
        Postures at both ends.

    Returns
    -------
    Checked

    Raises
    ------
    ArgumentError
        As `check`; not as many ends as starts.

    Examples
    --------
    >>> from agrik_fast import Robot, motion
    >>> arm = Robot.load("panda")
    >>> a = arm.random_q(100, seed=1)
    >>> motion.check_segments(arm, a, a + 0.1).outcome.shape
    (100,)
    """
    dof = checked_arm(arm).dof
    a, b = rows("start", start, dof), rows("end", end, dof)
    if a.shape != b.shape:
        raise ArgumentError("end", f"shape {b.shape}", f"shape {a.shape}, as start has")
    options = options_of(clear, own_clear, cap, tolerance, max_checks)
    collider = scene_of(scene).collider(arm)
    columns = _native.motion_check(collider, a, b, options, threads)
    return _checked(arm, collider, a, b, columns)


def _add_corners(
    columns: dict[str, Any],
    collider: _native.Collider,
    path: JointPath,
    options: dict[str, Any],
    threads: int | None,
) -> None:
    """Call pieces undecided that end in a rounded corner which is not proven free."""
    if path.blends is None:
        raise ArgumentError("path", "one smooth curve", "a path that is straight but for corners")
    rounded = np.flatnonzero(path.blends[1:-1] > 0) + 1
    if not len(rounded):
        return
    ends = corner_ends(path.q, path.lengths, path.blends, rounded)
    free = _native.motion_corners(collider, *ends, options, threads)
    for k in rounded[~free] - 1:
        if columns["outcome"][k] == Outcome.SAFE:
            columns["outcome"][k] = Outcome.UNDECIDED
            columns["clearance"][k] = 0.0
            columns["at"][k] = 1.0


def corner_ends(
    q: FloatArray, lengths: FloatArray, widths: FloatArray, corners: NDArray[np.intp]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return where curves leave the segments before corners, the corners, and where they end."""
    before = (widths[corners] / lengths[corners - 1])[:, np.newaxis]
    behind = (widths[corners] / lengths[corners])[:, np.newaxis]
    at = q[corners]
    return at + before * (q[corners - 1] - at), at, at + behind * (q[corners + 1] - at)


# -- what this room shares ---------------------------------------------------------------


def checked_arm(arm: object) -> Robot:
    """Return the arm, if it is one."""
    if not isinstance(arm, Robot):
        raise ArgumentError("arm", shown(arm), "a Robot")
    return arm


def scene_of(scene: object) -> Scene:
    """Return the scene; an empty one for None."""
    if scene is None:
        return Scene()
    if not isinstance(scene, Scene):
        raise ArgumentError("scene", shown(scene), "a Scene")
    return scene


def waypoints(path: Any, dof: int) -> FloatArray:
    """Return the waypoints of a path, shape (n, dof)."""
    for name in ("path", "q"):
        inner = getattr(path, name, None)
        if isinstance(inner, np.ndarray):
            path = inner
            break
    return rows("path", path, dof)


def rows(name: str, value: ArrayLike, dof: int) -> FloatArray:
    """Return rows of joint values; a single one is a row."""
    q = float_array(name, value)
    if q.ndim == 1:
        q = q[np.newaxis]
    if q.ndim != 2 or q.shape[1] != dof or len(q) == 0:
        raise ArgumentError(name, f"shape {q.shape}", f"shape (n, {dof}), one row or more")
    return finite_array(name, q, q.shape)


def contact_of(collider: _native.Collider, columns: dict[str, Any], k: int) -> Contact | None:
    """Return a contact with its names."""
    body, thing, other = (int(columns[name][k]) for name in ("body", "object", "other_body"))
    if body < 0:
        return None
    names: Sequence[str] = collider.bodies.names
    own = other >= 0
    return Contact(
        body=names[body],
        other=names[other] if own else collider.scene.names[thing],
        is_own=own,
        distance=float(columns["distance"][k]),
        points=np.array(columns["points"][k]),
    )


def inside(arm: Robot, q: FloatArray) -> bool:
    """Say whether joint values are within the limits, but for rounding."""
    return bool(((q >= arm.lower - 1e-9) & (q <= arm.upper + 1e-9)).all())


def options_of(
    clear: float, own: float | None, cap: float | None, tolerance: float, max_checks: int
) -> dict[str, Any]:
    return {
        "clear": clear,
        "own_clear": own,
        "cap": np.inf if cap is None else cap,
        "tolerance": tolerance,
        "segment_checks": max_checks,
    }


def _checked(
    arm: Robot,
    collider: _native.Collider,
    q: FloatArray,
    to: FloatArray,
    columns: dict[str, Any],
) -> Checked:
    contacts = columns["contact"]
    return Checked(
        q=q,
        outcome=columns["outcome"],
        clearance=columns["clearance"],
        at=columns["at"],
        checks=columns["checks"],
        contacts=tuple(contact_of(collider, contacts, k) for k in range(len(columns["outcome"]))),
        within_limits=inside(arm, q) and inside(arm, to),
        _to=to,
    )
