"""What became of each target, as columns of numbers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray, word
from .._tables import Tabular, joint_columns
from ..errors import ArgumentError
from ..motion import Fewest, Plan

__all__ = ["Attempt", "Decision", "Decisions", "Stage", "Status"]

CLOSE = 0.010
"""Distances below this bring a warning, m."""
GAP = 0.010
"""So much between the distance of the spheres and the exact one brings a warning, m."""


class Status(IntEnum):
    """What became of a target.

    Examples
    --------
    >>> found = ik.harvest.plan("cucumber", ik.harvest.example_scene(), ["C1", "C3"])
    >>> [ik.harvest.Status(code).name for code in found.status]
    ['OK', 'APPROACH_BLOCKED']
    """

    OK = 0
    """There is a posture, free of collisions and within the limits."""
    BAD_INPUT = 1
    """The grip point is no place: NaN or infinity."""
    OUT_OF_REACH = 2
    """The arm comes there at no approach angle and place of the slide of the grid."""
    JOINT_LIMITS = 3
    """It would, but for its joint limits."""
    APPROACH_BLOCKED = 4
    """The gripper hits something at every approach angle."""
    NO_COLLISION_FREE = 5
    """At all postures looked at the arm hits something or comes too near."""
    TIME_LIMIT = 6
    """The time was over."""


class Stage(IntEnum):
    """Which part of the method found a posture, in the order in which they are tried.

    Examples
    --------
    >>> found = ik.harvest.plan("cucumber", ik.harvest.example_scene(), ["C1"])
    >>> ik.harvest.Stage(found.stage[0]).name
    'FIRST'
    """

    FIRST = 0
    """The best approach angle."""
    NEXT_ANGLE = 1
    """Another approach angle."""
    FINER_GRID = 2
    """A finer grid round near misses."""
    TILT_SHIFT = 3
    """A tilted gripper, or a shifted grip point."""
    FULL_SCAN = 4
    """All approach angles."""


@dataclass(frozen=True)
class Attempt:
    """One approach whose table was made.

    Attributes
    ----------
    psi : float
        Approach angle, rad.
    tilt, shift : float
        Tilt of the gripper up, rad, and shift of the grip point up, m.
    stage : Stage
        Part of the method that made it.
    reached, within, admissible : int
        Postures: without regard to limits, within them, and free as well.

    Examples
    --------
    >>> one = ik.harvest.plan("cucumber", ik.harvest.example_scene(), ["C1"])["C1"]
    >>> one.attempts[0].admissible > 0
    True
    """

    psi: float
    tilt: float
    shift: float
    stage: Stage
    reached: int
    within: int
    admissible: int


@dataclass(frozen=True, eq=False)
class Decision:
    """What became of one target.

    Attributes
    ----------
    name : str
    status : Status
    q : ndarray, shape (7,), m and rad
        The posture; values near zero where there is none.
    psi : float
        Approach angle, rad.
    slide : float
        Place of the slide, m.
    branch : int
        Which branch of the arm behind the slide; -1 for none.
    distance : float
        Distance from the crop as it was measured, m.
    exact_distance : float
        The same between the bodies as they are, m.
    freedom, score : float
        Joint freedom, 0 to 1, and what the choice went by.
    stage : Stage
        Which part of the method found it.
    tilt, shift : float
        Tilt of the gripper, rad, and shift of the grip point, m.
    refined : bool
        A pattern search has made it better.
    warnings : tuple of str
        A wrist that is nearly straight, little distance, spheres that are far from exact.
    angles, open : int
        Approach angles looked at, and those at which the gripper is free.
    singular : int
        Places of the slide that were skipped, as the shoulder is singular there.
    attempts : tuple of Attempt
    path : motion.Plan or None
        The way into a posture, where it was asked for; it ends in `q`, or in another admissible
        posture where no way leads there.
    blockers_path : tuple of str or None
        The fewest removable objects without which a path is found, where there is a posture and
        no path; None where that does not help, or there is nothing to help.
    blockers_fewest : motion.Fewest or None
        What is known of their number.
    blockers_at_least : int or None
        With fewer no path was found.

    Examples
    --------
    >>> one = ik.harvest.plan("cucumber", ik.harvest.example_scene(), ["C1"])["C1"]
    >>> one.status.name, one.stage.name, one.q.shape
    ('OK', 'FIRST', (7,))
    """

    name: str
    status: Status
    q: FloatArray
    psi: float
    slide: float
    branch: int
    distance: float
    exact_distance: float
    freedom: float
    score: float
    stage: Stage
    tilt: float
    shift: float
    refined: bool
    warnings: tuple[str, ...]
    angles: int
    open: int
    singular: int
    attempts: tuple[Attempt, ...]
    path: Plan | None = None
    blockers_path: tuple[str, ...] | None = None
    blockers_fewest: Fewest | None = None
    blockers_at_least: int | None = None

    @property
    def ok(self) -> bool:
        """There is a posture to go to."""
        return self.status == Status.OK

    @property
    def reachable_posture(self) -> bool:
        """There is a posture, whether or not a path leads into it."""
        return self.ok

    @property
    def reachable_path(self) -> bool:
        """A path into a posture was found, and is proven free."""
        return self.path is not None and self.path.ok


@dataclass(frozen=True, eq=False)
class Decisions(Tabular):
    """What became of many targets, one entry each; see `Decision` for the columns.

    ``decisions["C1"]`` and ``decisions[0]`` are the `Decision` of one target.

    Attributes
    ----------
    names : tuple of str
    status : ndarray of uint8, shape (n,)
        Codes of `Status`.
    found : ndarray of bool, shape (n,)
        There is a posture.
    q : ndarray, shape (n, 7), m and rad
    psi, slide, distance, exact_distance, freedom, score, tilt, shift : ndarray, shape (n,)
    branch, angles, open, singular : ndarray of int, shape (n,)
    stage : ndarray of uint8, shape (n,)
        Codes of `Stage`.
    refined, straight : ndarray of bool, shape (n,)
        A pattern search made it better; the wrist is nearly straight.

    Examples
    --------
    >>> found = ik.harvest.plan("cucumber", ik.harvest.example_scene(), ["C1", "C3"])
    >>> found.names, found.q.shape, found["C1"].name
    (('C1', 'C3'), (2, 7), 'C1')
    """

    names: tuple[str, ...]
    columns: dict[str, Any]

    def __getattr__(self, name: str) -> NDArray[Any]:
        # A record that is being copied has no columns yet.
        columns = vars(self).get("columns", {})
        if name not in columns:
            raise AttributeError(name)
        return np.asarray(columns[name])

    def to_dict(self) -> dict[str, Any]:
        """Return the targets' names and the columns by their names.

        Examples
        --------
        >>> found = ik.harvest.plan("cucumber", ik.harvest.example_scene(), ["C1", "C3"])
        >>> found.to_dict()["names"]
        ('C1', 'C3')
        """
        return {"names": self.names, **self.columns}

    def _columns(self) -> dict[str, Any]:
        table: dict[str, Any] = {
            "target": list(self.names),
            "status": [Status(code).name.lower() for code in self.status.tolist()],
            **joint_columns("q", self.q),
        }
        for name, column in self.columns.items():
            if isinstance(column, np.ndarray) and column.ndim == 1:
                table.setdefault(name, column)
        return table

    @property
    def status(self) -> NDArray[np.uint8]:
        """Codes of `Status`."""
        return np.asarray(self.columns["status"])

    @property
    def ok(self) -> NDArray[np.bool_]:
        """Which targets have a posture to go to."""
        return np.asarray(self.status == Status.OK)

    @property
    def paths(self) -> list[Plan]:
        """The ways into the postures, where they were asked for."""
        if "paths" not in self.columns:
            raise ArgumentError("path", "False", "True in the call of plan, for paths")
        return list(self.columns["paths"])

    @property
    def reachable_posture(self) -> NDArray[np.bool_]:
        """Which targets have a posture, whether or not a path leads into it."""
        return self.ok

    @property
    def reachable_path(self) -> NDArray[np.bool_]:
        """Which targets have a path that is proven free."""
        return np.array([path.ok for path in self.paths], dtype=bool)

    def __len__(self) -> int:
        return len(self.names)

    def __iter__(self) -> Iterator[Decision]:
        return (self[k] for k in range(len(self)))

    def __getitem__(self, target: str | int) -> Decision:
        if isinstance(target, str):
            word("target", target, self.names)
            target = self.names.index(target)
        k = range(len(self))[target]
        of = {name: column[k] for name, column in self.columns.items() if name != "attempts"}
        return Decision(
            name=self.names[k],
            status=Status(of["status"]),
            q=np.array(of["q"]),
            branch=int(of["branch"]),
            stage=Stage(of["stage"]),
            refined=bool(of["refined"]),
            warnings=self._warnings(k),
            angles=int(of["angles"]),
            open=int(of["open"]),
            singular=int(of["singular"]),
            attempts=tuple(self._attempts(k)),
            path=of.get("paths"),
            blockers_path=of.get("blockers_path"),
            blockers_fewest=of.get("blockers_fewest"),
            blockers_at_least=of.get("blockers_at_least"),
            **{
                name: float(of[name])
                for name in (
                    "psi",
                    "slide",
                    "distance",
                    "exact_distance",
                    "freedom",
                    "score",
                    "tilt",
                    "shift",
                )
            },
        )

    def _attempts(self, k: int) -> Iterator[Attempt]:
        table = self.columns["attempts"]
        for row in np.flatnonzero(np.asarray(table["target"]) == k):
            yield Attempt(
                psi=float(table["psi"][row]),
                tilt=float(table["tilt"][row]),
                shift=float(table["shift"][row]),
                stage=Stage(table["stage"][row]),
                reached=int(table["reached"][row]),
                within=int(table["within"][row]),
                admissible=int(table["admissible"][row]),
            )

    def _warnings(self, k: int) -> tuple[str, ...]:
        if not self.columns["found"][k]:
            return ()
        found = []
        distance, exact = self.columns["distance"][k], self.columns["exact_distance"][k]
        if self.columns["straight"][k]:
            found.append("the wrist is nearly straight")
        if distance < CLOSE:
            found.append(f"{1e3 * distance:.1f} mm from the crop")
        if exact - distance > GAP:
            found.append(f"spheres are {1e3 * (exact - distance):.1f} mm nearer than the bodies")
        return tuple(found)

    def shares(self) -> dict[str, float]:
        """Return the share of the targets with each status that occurs, most frequent first.

        Examples
        --------
        >>> found = ik.harvest.plan("cucumber", ik.harvest.example_scene(), ["C1", "C3"])
        >>> found.shares()
        {'OK': 0.5, 'APPROACH_BLOCKED': 0.5}
        """
        codes, counts = np.unique(self.status, return_counts=True)
        order = np.argsort(-counts, kind="stable")
        total = max(1, len(self))
        return {Status(codes[k]).name: float(counts[k]) / total for k in order}

    def __repr__(self) -> str:
        return f"Decisions({len(self)} targets, {int(self.ok.sum())} OK)"
