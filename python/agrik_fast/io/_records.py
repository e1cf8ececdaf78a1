"""Chunks of targets and of results, and the names that result files hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..result import IkResult, Status
from ._extras import Extra, Extras, joined

STATUS_NAMES = tuple(status.name.lower() for status in Status)
"""Names of the statuses in files, in the order of their codes."""

FIXED_COLUMNS = (
    "status",
    "success",
    "position_error_m",
    "orientation_error_rad",
    "iterations",
    "restarts",
)
"""Columns of every result file, after the row's id and its joint values."""

SCENE_COLUMNS = ("clearance_m", "body", "object")
"""Columns after those, of results that were to keep clear of a scene."""

METADATA_PREFIX = "agrik_fast."
"""What the keys of a Parquet schema's metadata begin with."""


@dataclass(frozen=True)
class TargetChunk:
    """Consecutive targets of a file.

    Attributes
    ----------
    first : int
        Index of the chunk's first target in the file, from 0.
    targets : ndarray, shape (n, 3) in m, or (n, 4, 4)
        Tool points or tool poses in the robot's base frame.
    ids : ndarray, shape (n,)
        Row ids of the file, as int64 or text; row numbers from 1 where the file has none.
    extras : mapping of str to ndarray, shape (n,)
        Columns that are passed on to the results.

    Examples
    --------
    >>> from agrik_fast.io import TargetChunk
    >>> chunk = TargetChunk(first=0, targets=np.zeros((2, 3)), ids=np.array([1, 2]))
    >>> chunk.targets.shape
    (2, 3)
    """

    first: int
    targets: NDArray[np.float64]
    ids: NDArray[Any]
    extras: Extras = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.targets)


@dataclass(frozen=True)
class ResultLayout:
    """What every row of a result file holds besides the fixed columns.

    Attributes
    ----------
    joint_columns : tuple of str
        One per joint, the name with its unit: ``theta_rad``, ``s10_m``.
    text_ids : bool
        True if the row ids are text.
    metadata : dict of str
        How the results were made (robot, task, solver, seed, ...); kept in NPZ and Parquet.
    name_letters : int
        Letters of the longest name in the columns on a scene; 0 where there are none.
    extras : tuple of Extra
        Columns that are passed on from the targets, behind all others.

    Examples
    --------
    >>> from agrik_fast.io import ResultLayout
    >>> arm = ik.Robot.load("strawberry")
    >>> ResultLayout(ResultLayout.joint_names(arm.joint_names, arm.joint_types)).joint_columns
    ('s10_m', 's21_m', 's32_m', 'theta_rad', 'beta_rad')
    """

    joint_columns: tuple[str, ...]
    text_ids: bool = False
    metadata: dict[str, str] = field(default_factory=dict)
    name_letters: int = 0
    extras: tuple[Extra, ...] = ()

    @property
    def own_columns(self) -> tuple[str, ...]:
        """Names of all columns that are not passed on, in order."""
        scene = SCENE_COLUMNS if self.name_letters else ()
        return ("id", *self.joint_columns, *FIXED_COLUMNS, *scene)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of all columns, in order."""
        return (*self.own_columns, *(extra.name for extra in self.extras))

    @staticmethod
    def joint_names(names: Sequence[str], types: Sequence[str]) -> tuple[str, ...]:
        """Return column names of joints: ``_m`` for prismatic ones, ``_rad`` for the others.

        Examples
        --------
        >>> from agrik_fast.io import ResultLayout
        >>> ResultLayout.joint_names(["slide", "elbow"], ["prismatic", "revolute"])
        ('slide_m', 'elbow_rad')
        """
        return tuple(
            f"{name}_{'m' if kind == 'prismatic' else 'rad'}"
            for name, kind in zip(names, types, strict=True)
        )


@dataclass(frozen=True)
class SceneColumns:
    """What answers are nearest to in a scene.

    Attributes
    ----------
    clearance : ndarray, shape (n,), m
        Distance of the nearest collision; 0 or less in contact, infinite for none.
    body, object : ndarray of text, shape (n,)
        Names of the body and of the object, or other body, that it is nearest to.

    Examples
    --------
    >>> from agrik_fast.io import SceneColumns
    >>> columns = SceneColumns(np.array([0.02]), np.array(["gripper"]), np.array(["leaf"]))
    >>> str(columns.body[0])
    'gripper'
    """

    clearance: NDArray[np.float64]
    body: NDArray[np.str_]
    object: NDArray[np.str_]

    @classmethod
    def of(cls, result: IkResult) -> SceneColumns | None:
        """Return what answers are nearest to; None without a scene."""
        clearance, pairs = result.clearance, result.nearest_pair
        if clearance is None or pairs is None:
            return None
        body, thing = pairs.astype(np.str_).T
        return cls(clearance, body, thing)


@dataclass(frozen=True)
class ResultChunk:
    """Consecutive results.

    Attributes
    ----------
    ids : ndarray, shape (n,)
        Row ids as read, int64 or text.
    q : ndarray, shape (n, dof), rad or m
        Joint values; of an unsolved row the best found.
    status : ndarray, shape (n,)
        Codes of `agrik_fast.Status`.
    success : ndarray of bool, shape (n,)
    position_error : ndarray, shape (n,), m
    orientation_error : ndarray, shape (n,), rad
    iterations, restarts : ndarray, shape (n,)
    scene : SceneColumns or None
        What they are nearest to, of answers that were to keep clear of a scene.
    extras : mapping of str to ndarray, shape (n,)
        Columns that are passed on from the targets.

    Examples
    --------
    >>> from agrik_fast.io import ResultChunk
    >>> one = np.ones(1, dtype=int)
    >>> q, none = np.ones((1, 6)), np.zeros(1)
    >>> chunk = ResultChunk(one, q, 0 * one, one > 0, none, none, one, one)
    >>> chunk.q.shape
    (1, 6)
    >>> chunk
    ResultChunk(1 row: 1 solved, 6 joints)
    """

    ids: NDArray[Any]
    q: NDArray[np.float64]
    status: NDArray[np.integer[Any]]
    success: NDArray[np.bool_]
    position_error: NDArray[np.float64]
    orientation_error: NDArray[np.float64]
    iterations: NDArray[np.integer[Any]]
    restarts: NDArray[np.integer[Any]]
    scene: SceneColumns | None = None
    extras: Extras = field(default_factory=dict)

    @classmethod
    def of(cls, result: IkResult, ids: NDArray[Any], extras: Extras | None = None) -> ResultChunk:
        """Return what the solver found for rows of these ids."""
        return cls(
            ids=ids,
            q=result.q,
            status=result.status,
            success=result.success,
            position_error=result.position_error,
            orientation_error=result.orientation_error,
            iterations=result.iterations,
            restarts=result.restarts,
            scene=SceneColumns.of(result),
            extras={} if extras is None else extras,
        )

    def __len__(self) -> int:
        return len(self.status)

    def __repr__(self) -> str:
        rows = "1 row" if len(self) == 1 else f"{len(self)} rows"
        solved = int(np.count_nonzero(self.success))
        joints = self.q.shape[1]
        return f"ResultChunk({rows}: {solved} solved, {joints} joint{'s' * (joints != 1)})"

    @staticmethod
    def joined(chunks: Sequence[ResultChunk]) -> ResultChunk:
        """Return chunks that follow one another as one.

        Examples
        --------
        >>> from agrik_fast.io import ResultChunk
        >>> one = np.ones(1, dtype=int)
        >>> q, none = np.ones((1, 6)), np.zeros(1)
        >>> chunk = ResultChunk(one, q, 0 * one, one > 0, none, none, one, one)
        >>> len(ResultChunk.joined([chunk, chunk]).ids)
        2
        """

        def whole(parts: Sequence[Any], name: str) -> NDArray[Any]:
            return np.concatenate([getattr(part, name) for part in parts])

        apart = ("scene", "extras")
        names = [name for name in ResultChunk.__dataclass_fields__ if name not in apart]
        scenes = [chunk.scene for chunk in chunks if chunk.scene is not None]
        scene = None
        if scenes:
            fields = SceneColumns.__dataclass_fields__
            scene = SceneColumns(**{name: whole(scenes, name) for name in fields})
        columns = {name: whole(chunks, name) for name in names}
        extras = joined([chunk.extras for chunk in chunks])
        return ResultChunk(**columns, scene=scene, extras=extras)


def scene_columns(
    layout: ResultLayout, chunk: ResultChunk
) -> tuple[NDArray[np.float64], NDArray[np.str_], NDArray[np.str_]] | None:
    """Return the columns on a scene in the order of `SCENE_COLUMNS`; None where there are none.

    Raises
    ------
    ValueError
        The layout has such columns and the chunk has none, or the other way round.
    """
    if bool(layout.name_letters) != (chunk.scene is not None):
        raise ValueError("a layout with columns on a scene belongs to chunks that have them")
    if chunk.scene is None:
        return None
    return chunk.scene.clearance, chunk.scene.body, chunk.scene.object
