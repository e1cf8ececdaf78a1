"""The jobs that exist on their own: inverse and forward kinematics of rows."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from .._checks import whole_number
from .._files import Refusal, listing
from .._native import __version__
from ..io import (
    ResultChunk,
    ResultLayout,
    ResultTable,
    TargetTable,
    check_number_columns,
    import_pyarrow,
    number_columns,
)
from ..result import Status
from ..robot import Robot
from ..rotations import quat_of
from ._job import Done, JobError
from ._task import (
    Near,
    Vector,
    check_start,
    check_tolerances,
    choose_task,
    solver_words,
    task_words,
)

if TYPE_CHECKING:
    from ..solvers import Solver

_SEEDS = 2**64 - 1


def _refuse(reason: str) -> JobError:
    return JobError("partition", reason)


def load_robot(robot: Robot | str | PathLike[str]) -> Robot:
    """Return a robot, loading it if a name or a path is given."""
    return robot if isinstance(robot, Robot) else Robot.load(robot)


@dataclass(frozen=True)
class SolveJob:
    """Inverse kinematics of every row.

    Parameters
    ----------
    robot : Robot
    task, solver, position_tolerance, orientation_tolerance, tool_axis, direction, seed
        As of `SolveRequest`; a solver may also be an object of `agrik_fast.solvers`.
    tolerance_frame, mask, mask_frame, q0
        As of `SolveRequest`.
    tool : array_like, shape (4, 4), optional
        As for `Robot.ik`.
    passed_on : tuple of str
        Columns that are passed on to the results as they are, behind the results' own.

    Raises
    ------
    ArgumentError
        A tolerance or a seed out of its range. What else is wrong is raised by `columns`, in
        the words of `Robot.ik`.

    Examples
    --------
    >>> from agrik_fast.jobs import SolveJob
    >>> job = SolveJob(ik.Robot.load("ur5"), position_tolerance=1e-5)
    >>> job.name
    'solve'
    """

    robot: Robot
    task: str | None = None
    solver: Solver | str = "lm"
    position_tolerance: Near = 1e-6
    orientation_tolerance: Near = 1e-6
    tool_axis: Vector = (0.0, 0.0, 1.0)
    direction: Vector | None = None
    seed: int = 0
    tool: ArrayLike | None = None
    tolerance_frame: Literal["base", "tool"] | None = None
    mask: tuple[float, ...] | None = None
    mask_frame: Literal["base", "tool"] = "base"
    q0: tuple[float, ...] | None = None
    passed_on: tuple[str, ...] = ()

    name: str = field(default="solve", init=False)
    success: str = field(default="converged", init=False)

    def __post_init__(self) -> None:
        check_tolerances(self)
        whole_number("seed", self.seed, 0, _SEEDS)

    def identity(self) -> Mapping[str, Any]:
        """Return all that decides the results."""
        solver: Any = self.solver
        if not isinstance(solver, str):
            solver = {"name": solver.name, **dataclasses.asdict(solver)}
        return {
            "robot": f"{self.robot.name} {self.robot.fingerprint}",
            "task": self.task,
            "solver": solver,
            "position_tolerance_m": self.position_tolerance,
            "orientation_tolerance_rad": self.orientation_tolerance,
            "tolerance_frame": self.tolerance_frame,
            "mask": self.mask,
            "mask_frame": self.mask_frame,
            "q0": self.q0,
            "tool_axis": [float(x) for x in self.tool_axis],
            "direction": None if self.direction is None else [float(x) for x in self.direction],
            "seed": int(self.seed),
            "tool": None if self.tool is None else np.asarray(self.tool, dtype=float).tolist(),
        }

    def passing_on(self, schema: Any) -> SolveJob:
        """Return the job that passes on all columns which say nothing to it.

        Parameters
        ----------
        schema : pyarrow.Schema
            Of the source. Of two columns of one name the result's own is kept; nested columns
            and bytes are left out.

        Examples
        --------
        >>> import pyarrow
        >>> from agrik_fast.jobs import SolveJob
        >>> names = ("x_m", "y_m", "z_m", "mass_kg")
        >>> schema = pyarrow.schema([(name, pyarrow.float64()) for name in names])
        >>> SolveJob(ik.Robot.load("ur5")).passing_on(schema).passed_on
        ('mass_kg',)
        """
        own = self._layout(text_ids=False).own_columns
        extras = TargetTable(schema, _refuse).extras
        return dataclasses.replace(
            self, passed_on=tuple(name for name in extras if name not in own)
        )

    def columns(self, schema: Any, refuse: Refusal) -> tuple[str, ...]:
        """Return the columns with position, orientation and id, and those passed on."""
        check_start(self, self.robot)
        table = TargetTable(schema, refuse)
        for name in self.passed_on:
            if name not in table.extras:
                found = listing(table.extras) or "none"
                raise refuse(f"no column '{name}' that can be passed on; found {found}")
        _, task = choose_task(self, is_pose=table.is_pose)
        # No rows: names, solvers and tools are looked at before a thousand machines begin.
        none = np.zeros((0, 4, 4) if table.is_pose else (0, 3))
        self.robot.ik(none, task=task, solver=self.solver, seed=self.seed, tool=self.tool)
        return (*table.names, *self.passed_on)

    def schema(self, source: Any) -> Any:
        """Return the schema of results, with how they are made as its metadata."""
        schema = self._results(TargetTable(source, _refuse)).schema
        for name in self.passed_on:
            kind = source.field(name).type
            schema = schema.append(self._field(name, kind))
        return schema

    @staticmethod
    def _field(name: str, kind: Any) -> Any:
        """Return the field of a column that is passed on: without the dictionary of a source."""
        pyarrow = import_pyarrow(_refuse)
        plain = kind.value_type if pyarrow.types.is_dictionary(kind) else kind
        return pyarrow.field(name, plain)

    def _layout(self, *, text_ids: bool, metadata: dict[str, str] | None = None) -> ResultLayout:
        joints = ResultLayout.joint_names(self.robot.joint_names, self.robot.joint_types)
        return ResultLayout(joints, text_ids, metadata or {})

    def _results(self, targets: TargetTable) -> ResultTable:
        name, _ = choose_task(self, is_pose=targets.is_pose)
        metadata = {"version": __version__, "robot": self.robot.name, "task": name}
        metadata |= {"solver": solver_words(self.solver), **task_words(self, name)}
        layout = self._layout(text_ids=targets.has_text_ids, metadata=metadata)
        return ResultTable(layout, _refuse)

    def work(self, batch: Any, first: int) -> Done:
        """Solve rows."""
        table = TargetTable(batch.schema, _refuse)
        table.row_bytes(first, batch)
        chunk = table.chunk(first, batch)
        _, task = choose_task(self, is_pose=table.is_pose)
        result = self.robot.ik(
            chunk.targets,
            task=task,
            solver=self.solver,
            seed=self.seed,
            tool=self.tool,
            q0=self.q0,
            position_tolerance=self.position_tolerance,
            orientation_tolerance=self.orientation_tolerance,
            tolerance_frame=self.tolerance_frame,
            first_index=first,
        )
        codes = np.bincount(result.status, minlength=len(Status))
        counts = {status.name.lower(): int(codes[status]) for status in Status if codes[status]}
        results = self._results(table).table(ResultChunk.of(result, chunk.ids))
        for name in self.passed_on:
            column = batch.column(batch.schema.get_field_index(name))
            field = self._field(name, column.type)
            results = results.append_column(field, column.cast(field.type))
        return Done(results, counts)


@dataclass(frozen=True)
class ForwardJob:
    """Forward kinematics of every row: joint values to the tool's pose.

    The columns read are the joints' names with their units, as result files have them
    (``theta_rad``, ``s10_m``); those written are ``id``, ``x_m``, ``y_m``, ``z_m``, ``qx``,
    ``qy``, ``qz``, ``qw``, which `SolveJob` reads. A row that is not finite gives NaN.

    Parameters
    ----------
    robot : Robot

    Examples
    --------
    >>> from agrik_fast.jobs import ForwardJob
    >>> ForwardJob(ik.Robot.load("ur5")).name
    'forward'
    """

    robot: Robot

    name: str = field(default="forward", init=False)
    success: str = field(default="finite", init=False)

    @property
    def _joints(self) -> tuple[str, ...]:
        return ResultLayout.joint_names(self.robot.joint_names, self.robot.joint_types)

    def identity(self) -> Mapping[str, Any]:
        """Return all that decides the results."""
        return {"robot": f"{self.robot.name} {self.robot.fingerprint}"}

    def columns(self, schema: Any, refuse: Refusal) -> tuple[str, ...]:
        """Return the columns of the joints, and of the id where it is a whole number."""
        check_number_columns(schema, self._joints, refuse)
        pyarrow = import_pyarrow(refuse)
        has_id = "id" in schema.names and pyarrow.types.is_integer(schema.field("id").type)
        return (*self._joints, *(["id"] if has_id else []))

    def schema(self, source: Any) -> Any:
        """Return the schema of poses."""
        pyarrow = import_pyarrow(_refuse)
        names = ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
        fields = [("id", pyarrow.int64()), *((name, pyarrow.float64()) for name in names)]
        words = {"agrik_fast.version": __version__, "agrik_fast.robot": self.robot.name}
        return pyarrow.schema(fields, metadata=words)

    def work(self, batch: Any, first: int) -> Done:
        """Return the poses of rows."""
        pyarrow = import_pyarrow(_refuse)
        q = number_columns(first, batch, self._joints, _refuse)
        finite = np.isfinite(q).all(axis=1)
        pose = np.full((len(q), 7), np.nan)
        if finite.any():
            T = self.robot.fk(q[finite])
            pose[finite] = np.hstack([T[:, :3, 3], quat_of(T)])
        if "id" in batch.schema.names:
            ids = batch.column(batch.schema.get_field_index("id")).cast(pyarrow.int64())
        else:
            ids = pyarrow.array(np.arange(first + 1, first + len(q) + 1))
        columns = [ids, *(pyarrow.array(np.ascontiguousarray(pose[:, k])) for k in range(7))]
        table = pyarrow.Table.from_arrays(columns, schema=self.schema(batch.schema))
        return Done(table, {"finite": int(finite.sum()), "bad_input": int((~finite).sum())})
