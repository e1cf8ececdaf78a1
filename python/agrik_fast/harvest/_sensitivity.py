"""How errors of joints, lengths and vision become errors of the tool and of the clearance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, finite_array, real_number, shown, whole_number
from ..collision import Scene, Target
from ..errors import ArgumentError
from ..robot import Robot
from ._programme import Programme

__all__ = ["Errors", "Sensitivity", "Simulated", "sensitivity", "simulate"]

# Step of the central differences of points on bodies, rad and m.
_STEP = 1e-6


@dataclass(frozen=True)
class Errors:
    """Sizes of errors, as standard deviations; all assumed unless measured.

    Parameters
    ----------
    joint : float, default 0.1 degrees, rad
        Of turning joints: encoder offsets.
    slide : float, default 0.5e-3, m
        Of sliding joints.
    length : float, default 0.5e-3, m
        Of each length of the Denavit-Hartenberg table that is not zero.
    backlash : float, default 0, rad
        Play of turning joints, all of it; its direction is not known.
    vision : float, default 5e-3, m
        Of where the crop is seen, in each direction; the crop is off as a whole.
    camera : float, default 0, rad
        Of the camera's orientation about each axis, about the base.

    Raises
    ------
    ArgumentError
        A number that is negative or not finite.

    Examples
    --------
    >>> better = ik.harvest.Errors(vision=0.002)
    >>> better.vision
    0.002
    """

    joint: float = math.radians(0.1)
    slide: float = 0.5e-3
    length: float = 0.5e-3
    backlash: float = 0.0
    vision: float = 5e-3
    camera: float = 0.0

    def __post_init__(self) -> None:
        for name in ("joint", "slide", "length", "backlash", "vision", "camera"):
            real_number(name, getattr(self, name), 0.0)

    def joints(self, robot: Robot) -> FloatArray:
        """Return the standard deviation of each joint value, rad or m; play counts as even.

        Examples
        --------
        >>> ik.harvest.Errors(slide=0.001).joints(ik.Robot.load("cucumber")).shape
        (7,)
        """
        turning = math.hypot(self.joint, self.backlash / math.sqrt(12))
        slides = np.array([kind == "prismatic" for kind in robot.joint_types])
        return np.where(slides, self.slide, turning)


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """First-order effects of errors at a posture.

    Attributes
    ----------
    covariance : ndarray, shape (3, 3), m^2
        Of the tool point relative to the fruit.
    rms : float
        Root of its trace, m.
    bodies : tuple of n str
        Bodies that move and have something near.
    clearance : ndarray, shape (n,), m
        Of each body.
    deviation : ndarray, shape (n,), m
        Standard deviation of each clearance.
    guaranteed : ndarray, shape (n,), m
        What is left of each clearance if every error is as large as its standard deviation
        and all of them add up.

    Examples
    --------
    >>> scene = ik.harvest.example_scene()
    >>> one = ik.harvest.plan("cucumber", scene, ["C1"])["C1"]
    >>> found = ik.harvest.sensitivity("cucumber", scene, "C1", one.q)
    >>> found.covariance.shape, len(found.bodies) == len(found.clearance)
    ((3, 3), True)
    """

    covariance: FloatArray
    rms: float
    bodies: tuple[str, ...]
    clearance: FloatArray
    deviation: FloatArray
    guaranteed: FloatArray

    @property
    def nearest(self) -> float:
        """Probability that the body most at risk is free: an upper bound to first order."""
        return float(_phi(self.clearance / self.deviation).min(initial=1.0))

    @property
    def free(self) -> float:
        """Least probability that all bodies are free: the union bound, of any correlation."""
        return max(0.0, 1.0 - float(_phi(-self.clearance / self.deviation).sum()))

    def min_distance(self, probability: float) -> float:
        """Return the distance to keep for a probability of staying free.

        Parameters
        ----------
        probability : float
            Above 0 and below 1.

        Returns
        -------
        float, m
            If the body whose clearance varies most keeps it, it is free with this probability:
            ``D_min`` of `Settings` for postures like this one.

        Raises
        ------
        ArgumentError
            A probability out of its range.

        Examples
        --------
        >>> scene = ik.harvest.example_scene()
        >>> one = ik.harvest.plan("cucumber", scene, ["C1"])["C1"]
        >>> found = ik.harvest.sensitivity("cucumber", scene, "C1", one.q)
        >>> found.min_distance(0.9) < found.min_distance(0.99)
        True
        """
        wanted = real_number("probability", probability, 0.0, 1.0, open_low=True)
        if wanted == 1:
            raise ArgumentError("probability", "1", "a number below 1")
        largest = float(self.deviation.max(initial=0.0))
        low, high = -40.0, 40.0
        for _ in range(200):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if float(_phi(np.array(middle))) < wanted else (low, middle)
        return max(0.0, high * largest)


@dataclass(frozen=True, eq=False)
class Simulated:
    """Errors drawn at random, without any linearisation.

    Attributes
    ----------
    rms : float
        Root mean square distance of the tool point from where it was to be, m.
    free : float
        Share of the draws in which the posture stays free.
    clearance : ndarray, shape (draws,), m
        Clearance of each.

    Examples
    --------
    >>> scene = ik.harvest.example_scene()
    >>> one = ik.harvest.plan("cucumber", scene, ["C1"])["C1"]
    >>> drawn = ik.harvest.simulate("cucumber", scene, "C1", one.q, draws=200)
    >>> 0.0 <= drawn.free <= 1.0
    True
    """

    rms: float
    free: float
    clearance: FloatArray


def _phi(x: FloatArray) -> FloatArray:
    """Return the normal distribution function."""
    erf = np.vectorize(math.erf, otypes=[float])
    return np.asarray(0.5 * (1 + erf(np.asarray(x) / math.sqrt(2))))


def sensitivity(
    robot: Robot | str,
    scene: Scene,
    target: str | Target | ArrayLike,
    q: ArrayLike,
    errors: Errors | None = None,
) -> Sensitivity:
    """Work out how errors show at a posture, to first order.

    The tool point: ``J S_q J' + J_l S_l J_l' + [r x] S_w [r x]' + S_v``. The clearance of a body
    changes by the way of its nearest point along the line to the nearest object.

    Parameters
    ----------
    robot, scene, target
        As for `Programme`.
    q : array_like, shape (dof,), rad and m
        The posture.
    errors : Errors, optional

    Returns
    -------
    Sensitivity

    Raises
    ------
    ArgumentError, UnknownNameError
        As `Programme`; `q` of another shape.

    Examples
    --------
    >>> scene = ik.harvest.example_scene()
    >>> one = ik.harvest.plan("cucumber", scene, ["C1"])["C1"]
    >>> found = ik.harvest.sensitivity("cucumber", scene, "C1", one.q)
    >>> 0.004 < found.rms < 0.02
    True
    """
    case = _Case(robot, scene, target, q, errors)
    arm, spread = case.robot, case.errors.joints(case.robot)
    jacobian = arm.jacobian(case.q)[:3]
    lengths, _ = case.length_directions(case.q[None])
    of_length = lengths[0] * case.errors.length
    covariance = (jacobian * spread**2) @ jacobian.T + of_length.T @ of_length
    covariance += case.seen(arm.fk(case.q)[:3, 3])
    found = case.near(scene)
    deviation, guaranteed = [], []
    for frame, point, normal, distance in found:
        rates = case.point_rates(frame, point) @ normal
        parts = np.concatenate(
            [
                rates * spread,
                (lengths[0] @ normal)[case.length_frames <= frame] * case.errors.length,
                [case.errors.vision] * 3 * normal,
                np.cross(point, normal) * case.errors.camera,
            ]
        )
        deviation.append(float(np.linalg.norm(parts)))
        guaranteed.append(distance - float(np.abs(parts).sum()))
    names = tuple(case.names)
    return Sensitivity(
        covariance,
        float(np.sqrt(np.trace(covariance))),
        names,
        np.array([one[3] for one in found]),
        np.array(deviation),
        np.array(guaranteed),
    )


def simulate(
    robot: Robot | str,
    scene: Scene,
    target: str | Target | ArrayLike,
    q: ArrayLike,
    errors: Errors | None = None,
    *,
    draws: int = 2000,
    seed: int = 0,
    threads: int | None = None,
) -> Simulated:
    """Draw errors at random and place the arm anew: what `sensitivity` is checked by.

    Parameters
    ----------
    robot, scene, target, q, errors
        As for `sensitivity`.
    draws : int, default 2000
    seed : int, default 0
    threads : int, optional

    Returns
    -------
    Simulated

    Raises
    ------
    ArgumentError, UnknownNameError
        As `sensitivity`.

    Examples
    --------
    >>> scene = ik.harvest.example_scene()
    >>> one = ik.harvest.plan("cucumber", scene, ["C1"])["C1"]
    >>> drawn = ik.harvest.simulate("cucumber", scene, "C1", one.q, draws=200)
    >>> drawn.clearance.shape
    (200,)
    """
    case = _Case(robot, scene, target, q, errors)
    count = whole_number("draws", draws, 1, 10**7)
    rng = np.random.default_rng(whole_number("seed", seed, 0))
    of = case.errors
    dof = len(case.q)
    moved = case.q + rng.normal(0, 1, (count, dof)) * np.where(
        [kind == "prismatic" for kind in case.robot.joint_types], of.slide, of.joint
    )
    turning = np.array([kind != "prismatic" for kind in case.robot.joint_types])
    moved += turning * rng.uniform(-0.5, 0.5, (count, dof)) * of.backlash
    directions, tool = case.length_directions(moved)
    lengths = rng.normal(0, of.length, (count, len(case.length_frames), 1))
    vision = rng.normal(0, of.vision, (count, 3))
    turn = rng.normal(0, of.camera, (count, 3))
    shifts = np.zeros((count, len(case.frames), 3))
    for body, frame in enumerate(case.frames):
        before = case.length_frames <= frame
        shifts[:, body] = (directions * lengths)[:, before].sum(axis=1)
    point = case.robot.fk(case.q)[:3, 3]
    off = vision + np.cross(turn, point)
    error = tool + (directions * lengths).sum(axis=1) - point - off
    # What is seen off by so much is as if the arm stood off by as much the other way.
    clearance = case.programme._native.clearances(moved, shifts - off[:, None], threads)
    return Simulated(
        float(np.sqrt((error**2).sum(axis=1).mean())),
        float((clearance > 0).mean()),
        clearance,
    )


class _Case:
    """A posture with what is near it, and the lengths of the arm."""

    def __init__(
        self,
        robot: Robot | str,
        scene: Scene,
        target: str | Target | ArrayLike,
        q: ArrayLike,
        errors: Errors | None,
    ) -> None:
        self.programme = Programme(robot, scene, target)
        self.robot = self.programme._crop.robot
        self.errors = Errors() if errors is None else errors
        if not isinstance(self.errors, Errors):
            raise ArgumentError("errors", shown(errors), "harvest.Errors")
        self.q = finite_array("q", q, (len(self.robot.joint_names),))
        if self.robot.dh is None or self.robot.convention != "modified":
            raise ArgumentError(
                "robot",
                f"{self.robot.name!r}, which has none",
                "an arm with modified Denavit-Hartenberg rows, whose lengths have errors",
            )
        frames = self.robot.compiled_bodies().frames
        last = len(self.robot.dh)
        self.frames = [min(frame, last) for frame in frames]
        # (frame that a length stands before, or in; whether it is along x)
        self.lengths = [
            (k + 1, along_x)
            for k, row in enumerate(self.robot.dh)
            for along_x, value in ((True, row.a), (False, row.d))
            if value != 0
        ]
        self.length_frames = np.array([frame for frame, _ in self.lengths], dtype=int)
        self.names: list[str] = []

    def length_directions(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the direction of each length, shape (n, lengths, 3), and the tool points."""
        poses = self.robot.fk_links(q)
        base = np.broadcast_to(self.robot.base, (len(q), 1, 4, 4))
        before = np.concatenate([base, poses], axis=1)
        each = [
            before[:, frame - 1, :3, 0] if along_x else before[:, frame, :3, 2]
            for frame, along_x in self.lengths
        ]
        return np.stack(each, axis=1), poses[:, -1, :3, 3]

    def seen(self, point: FloatArray) -> FloatArray:
        """Return the covariance of where a point is seen."""
        x, y, z = point
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        of = self.errors
        return np.asarray(of.vision**2 * np.eye(3) + of.camera**2 * cross @ cross.T)

    def near(self, scene: Scene) -> list[tuple[int, FloatArray, FloatArray, float]]:
        """Return frame, nearest point, direction from the object and distance of each body."""
        crop, chosen = self.programme._crop, self.programme._chosen
        static = {scene.names[k] for k in crop.statics}
        own = {scene.names[k] for k in chosen.objects[0]}
        touching = {crop.bodies.names[k] for k in crop.touching}
        kept = scene.without(*static)
        free = kept.without(*(name for name in own if name in kept.names))
        found = []
        self.names = []
        for part, wanted in ((kept, False), (free, True)):
            at = part.distances(self.robot, self.q)
            for k, name in enumerate(at.bodies):
                distance = float(at.distance[k])
                if (name in touching) != wanted or self.frames[k] == 0 or distance <= 0:
                    continue
                way = at.on_body[k] - at.on_object[k]
                if not np.isfinite(distance) or np.linalg.norm(way) == 0:
                    continue
                self.names.append(name)
                found.append((self.frames[k], at.on_body[k], way / np.linalg.norm(way), distance))
        return found

    def point_rates(self, frame: int, point: FloatArray) -> FloatArray:
        """Return how a point of a link moves with each joint value, shape (dof, 3)."""
        pose = self.robot.fk_links(self.q)[frame - 1]
        local = np.append(pose[:3, :3].T @ (point - pose[:3, 3]), 1.0)
        steps = _STEP * np.eye(len(self.q))
        ahead = self.robot.fk_links(self.q + steps)[:, frame - 1] @ local
        behind = self.robot.fk_links(self.q - steps)[:, frame - 1] @ local
        return np.asarray((ahead - behind)[:, :3] / (2 * _STEP))
