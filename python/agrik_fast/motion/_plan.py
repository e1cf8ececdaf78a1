"""Paths from a posture to a goal, every piece of them proven free."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .. import _native
from .._checks import FloatArray, finite_array
from .._tables import Postures, joint_columns
from ..collision import Scene
from ..robot import Robot
from ._check import Contact, checked_arm, contact_of, scene_of
from ._goals import Prefer, postures
from ._settings import Settings, checked_settings

__all__ = ["CutProof", "PathStatus", "Plan", "plan"]


class PathStatus(IntEnum):
    """What became of a plan, in the order in which reasons are looked for.

    Examples
    --------
    >>> from agrik_fast.motion import PathStatus
    >>> [each.name for each in PathStatus][:1]
    ['OK']
    """

    OK = 0
    """There is a path, and it is proven free."""
    BAD_INPUT = 1
    """The target is no place: NaN or infinity."""
    START_OUT_OF_LIMITS = 2
    """The start is outside the joint limits."""
    START_IN_COLLISION = 3
    """The start hits something, or is too near to it; `Plan.contact` says what."""
    OUT_OF_REACH = 4
    """The arm comes to the target in no way."""
    JOINT_LIMITS = 5
    """It would, but for its joint limits."""
    APPROACH_BLOCKED = 6
    """The gripper hits something in every posture."""
    NO_COLLISION_FREE = 7
    """The arm hits something, or is too near to it, in every posture."""
    NO_GOAL = 8
    """No goal was given."""
    PATH_IMPOSSIBLE = 9
    """It is proven that there is no path; `Plan.proof` is the proof."""
    NO_PATH_FOUND = 10
    """None was found with the effort allowed; that is no proof."""
    TIME_LIMIT = 11
    """The time was over."""


@dataclass(frozen=True, eq=False)
class CutProof:
    """A proof that there is no path: a ball inside a body is shut in.

    On a grid of cells a cell is open where the scene, without what may be touched, is no nearer
    to its centre than `radius` less half the cell's diagonal. However the arm moves, the centre
    of the ball goes through open cells that are neighbours (at corners too). The open cells that
    hang together with the ball's place at the goals (or, where `at_goal` is False, at the start)
    are `cells` in number, and its place at the other end is not among them.

    Attributes
    ----------
    body : str
        The body that holds the ball.
    radius, cell : float, m
        Of the ball, and the length of the cells.
    origin : ndarray, shape (3,), m
        Centre of one of the cells.
    cells : int
    at_goal : bool
    start : ndarray, shape (3,), m
    goals : ndarray, shape (m, 3), m
        Where the ball is at the start, and at every goal that is free.

    Examples
    --------
    >>> from agrik_fast.motion import CutProof
    >>> proof = CutProof("gripper", 0.03, 0.02, np.zeros(3), 10, True, np.zeros(3), np.ones((1, 3)))
    >>> proof.body
    'gripper'
    """

    body: str
    radius: float
    cell: float
    origin: FloatArray
    cells: int
    at_goal: bool
    start: FloatArray
    goals: FloatArray


@dataclass(frozen=True, eq=False)
class Plan(Postures):
    """The answer to a plan.

    Attributes
    ----------
    status : PathStatus
    how : str
        How the path goes, or was found: ``straight``, ``slide_first``, ``slide_last`` (one
        slide moves alone), the same behind ``retreat+`` where it ends with a line of the tool,
        ``rrt_connect``, ``retreat+rrt_connect``; empty for none.
    path : ndarray, shape (n, dof), rad or m
        Waypoints, between which it is straight in joint space; none where there is no path.
    clearance : ndarray, shape (n - 1,), m
        Distance that is kept on each piece, of bodies from the scene and from each other, as
        `check` tells it; of a path of one waypoint that of the posture.
    goal : ndarray, shape (dof,), or None
        The goal that the path ends at.
    goal_index : int
        Which of `goals` that is; -1 for none.
    goals : ndarray, shape (m, dof), rad or m
        All goals, the best first.
    checks, rounds : int
        Questions asked, and rounds of the trees.
    nearest : float, m
        How near the trees came in the metric of the joints, where they did not meet; else 0.
    contact : Contact or None
        What the start is too near to.
    proof : CutProof or None
        The proof that there is no path.

    Examples
    --------
    >>> from agrik_fast.motion import plan
    >>> arm = ik.Robot.load("panda")
    >>> start, goal = [-1, 0, 0, -1.5, 0, 1.5, 0], [1, 0, 0, -1.5, 0, 1.5, 0]
    >>> found = plan(arm, start, goal, ik.Scene([]))
    >>> found.status.name, found.path.shape[1]
    ('OK', 7)
    """

    status: PathStatus
    how: str
    path: FloatArray
    clearance: FloatArray
    goal_index: int
    goals: FloatArray
    checks: int
    rounds: int
    nearest: float
    contact: Contact | None
    proof: CutProof | None

    @property
    def ok(self) -> bool:
        """There is a path."""
        return self.status == PathStatus.OK

    @property
    def q(self) -> FloatArray:
        """The waypoints, as paths from elsewhere name them."""
        return self.path

    @property
    def goal(self) -> FloatArray | None:
        """The goal that the path ends at."""
        return self.goals[self.goal_index] if self.goal_index >= 0 else None

    @property
    def certified(self) -> float:
        """Distance that is kept all along the path, m; 0 without one."""
        return float(self.clearance.min()) if len(self.clearance) else 0.0

    @property
    def _rows(self) -> FloatArray:
        return self.path

    def to_dict(self) -> dict[str, Any]:
        """Return the attributes by their names.

        Examples
        --------
        >>> from agrik_fast.motion import plan
        >>> found = plan(ik.Robot.load("panda"), np.zeros(7) - 0.1, np.zeros(7) - 0.2, ik.Scene([]))
        >>> list(found.to_dict())[:3]
        ['status', 'how', 'path']
        """
        return {each.name: getattr(self, each.name) for each in fields(self)}

    def _columns(self) -> dict[str, Any]:
        # A clearance is that of the piece from a waypoint to the next.
        clearance = np.full(len(self.path), np.nan)
        clearance[: len(self.clearance)] = self.clearance
        return {**joint_columns("q", self.path), "clearance": clearance}

    def because(self, *, reached: bool) -> Plan:
        """Return the same where there was no goal, with the reason for that.

        Parameters
        ----------
        reached : bool
            The target is reached, but only outside the limits.

        Returns
        -------
        Plan
        """
        if self.status != PathStatus.NO_GOAL:
            return self
        return replace(self, status=PathStatus.JOINT_LIMITS if reached else PathStatus.OUT_OF_REACH)

    @classmethod
    def from_core(
        cls, collider: _native.Collider, goals: FloatArray, found: dict[str, Any]
    ) -> Plan:
        """Return what the compiled core found for an arm in a scene, with names.

        Parameters
        ----------
        collider : Collider
            The arm in its scene.
        goals : ndarray, shape (m, dof), rad or m
            The goals that were given.
        found : dict
            The record of the core.

        Returns
        -------
        Plan
        """
        contact, proof = found["contact"], found["proof"]
        if proof is not None:
            proof = CutProof(
                **{
                    **proof,
                    "body": collider.bodies.names[proof["body"]],
                    "origin": np.array(proof["origin"]),
                    "start": np.array(proof["start"]),
                }
            )
        return cls(
            status=PathStatus(found["status"]),
            how=found["how"],
            path=found["path"],
            clearance=found["clearance"],
            goal_index=-1 if found["goal"] is None else int(found["goal"]),
            goals=goals,
            checks=int(found["checks"]),
            rounds=int(found["rounds"]),
            nearest=float(found["nearest"]),
            contact=None if contact is None else contact_of(collider, contact, 0),
            proof=proof,
        )

    def __repr__(self) -> str:
        if not self.ok:
            return f"Plan({self.status.name}, {self.checks} checks)"
        return (
            f"Plan(OK, {self.how}, {len(self.path)} waypoints, "
            f"{1e3 * self.certified:.1f} mm, {self.checks} checks)"
        )


def plan(
    arm: Robot,
    start: ArrayLike,
    goals: ArrayLike,
    scene: Scene | None = None,
    *,
    settings: Settings | None = None,
    prefer: Prefer | None = None,
) -> Plan:
    """Find a path that is proven free from a posture to one of many goals.

    What costs little is tried first, with every goal: the straight way in joint space, ways on
    which one slide moves alone, straight lines of the tool backwards out of the goal; then two
    trees grow towards each other, from the start and from all goals and the ends of the lines
    (RRT-Connect). Every piece is proven by `check`'s method, so nothing is met between
    postures either. Answers depend on the arguments alone, unless there is a time limit.

    Parameters
    ----------
    arm : Robot
        An arm with bodies.
    start : array_like, shape (dof,), rad or m
        Where it is.
    goals : array_like, shape (dof,), (m, dof), (4, 4) or (k, 4, 4)
        Joint values, the best first; or poses of the tool in the base frame, m: all their
        postures are goals (`goals_of`).
    scene : Scene, optional
        What stands round it; default nothing. Where it aims at a target (`Scene.aiming_at`),
        that may be touched only while the tool point is near it.
    settings : Settings, optional
        What the path keeps, and how it is looked for.
    prefer : {"near", "clearance"}, optional
        Which goals are best: those near the start, or far from the scene. Default: the order
        given, and of poses those near.

    Returns
    -------
    Plan

    Raises
    ------
    ArgumentError
        A wrong shape, joint values that are not finite, a setting out of its range, an arm
        without bodies (says what to add).

    Notes
    -----
    RRT-Connect is of Kuffner and LaValle, "RRT-Connect: an efficient approach to single-query
    path planning", IEEE International Conference on Robotics and Automation (2000).

    Examples
    --------
    >>> from agrik_fast import Robot, motion
    >>> from agrik_fast.collision import Capsule, Scene, SceneObject
    >>> arm = Robot.load("panda")
    >>> post = SceneObject.of("post", Capsule([0.5, 0, 0], [0.5, 0, 1], 0.05))
    >>> start, goal = [-1, 0, 0, -1.5, 0, 1.5, 0], [1, 0, 0, -1.5, 0, 1.5, 0]
    >>> found = motion.plan(arm, start, goal, Scene([post]))
    >>> found.status.name, found.how
    ('OK', 'rrt_connect')
    >>> motion.check(arm, found, Scene([post])).safe
    True
    """
    dof = checked_arm(arm).dof
    options = checked_settings(settings)
    around = scene_of(scene)
    first = finite_array("start", start, (dof,))
    collider = around.collider(arm)
    rows, why = postures(arm, goals, around, first, prefer, options.seed)
    found = _native.motion_plan(collider, first, rows, options.as_options())
    if why is not None and found["status"] == PathStatus.NO_GOAL:
        found["status"] = PathStatus[why]
    return Plan.from_core(collider, rows, found)
