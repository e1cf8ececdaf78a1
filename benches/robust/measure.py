"""One solver on one arm and one kind of target: share solved, false claims, time."""

from __future__ import annotations

import time
import zlib
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import agrik_fast as ik
from agrik_fast import Status

from . import judge, postures, requests
from .chain import Arm, Array

PIECES = 20
"""Calls that a measurement is cut into; the time told is their median."""
FALSE = ("false success", "limits left", "not a number", "success and status differ")


@dataclass
class Measured:
    """What one measurement found."""

    arm: str
    kind: str
    task: str
    solver: str
    rows: int
    solved: int
    out_of_reach: int
    median_us: float
    iterations: float
    faults: Counter[str] = field(default_factory=Counter)
    example: dict[str, str] = field(default_factory=dict)

    @property
    def false_successes(self) -> int:
        """Rows whose success is none: errors above the tolerances, limits left, no numbers."""
        return sum(self.faults[kind] for kind in FALSE)

    @property
    def false_proofs(self) -> int:
        return self.faults["false proof"]

    @property
    def others(self) -> int:
        """Rows with any other broken promise."""
        return self.faults.total() - self.false_successes - self.false_proofs

    @property
    def share(self) -> float:
        return self.solved / self.rows if self.rows else 0.0


def measure(
    arm: Arm,
    robot: ik.Robot,
    kind: str,
    task: str,
    solver: str,
    rows: int,
    unit: float = 1.0,
    q: Array | None = None,
) -> Measured:
    """Solve targets of a kind and judge the answers.

    Parameters
    ----------
    arm, robot : Arm, Robot
        The same arm, ours and the library's.
    kind : str
        Kind of posture that the targets are made from, out of `postures.KINDS`; "out of reach"
        for points beyond all that the arm can reach.
    task : {"pose", "position"}
        What counts as reached.
    solver : str
        Name of a solver.
    rows : int
        How many targets.
    unit : float
        By which the position tolerance of 1e-6 m is multiplied: for arms in other units.
    q : ndarray, optional
        Postures to use instead of those drawn.
    """
    # The same targets for every solver, others for every arm and kind.
    rng = np.random.Generator(np.random.PCG64(zlib.crc32(f"{arm.name}, {kind}".encode())))
    if q is None:
        drawn = "random" if kind == "out of reach" else kind
        q = postures.draw(arm, drawn, rows, rng)
    poses = arm.fk(q)
    reachable = np.ones(rows, bool)
    if kind == "out of reach":
        _push_out(arm, poses, rng)
        reachable[:] = False
    options: dict[str, Any] = {"position_tolerance": 1e-6 * unit} if unit != 1.0 else {}
    request = requests.Request(
        arm=arm,
        task=task,
        task_name=task,
        solver=solver,
        solver_name=solver,
        targets=poses if task == "pose" else np.ascontiguousarray(poses[:, :3, 3]),
        poses=poses,
        reachable=reachable,
        made_from=q,
        options=options,
    )
    # What is computed once for an arm is not what a target takes.
    robot.ik(**request.piece(0, 1)(threads=1))
    cuts = np.linspace(0, rows, min(PIECES, rows) + 1).astype(int)
    parts, times = [], []
    for begin, end in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True):
        arguments = request.piece(begin, end)(threads=1)
        since = time.perf_counter()
        parts.append(robot.ik(**arguments))
        times.append((time.perf_counter() - since) / (end - begin))
    result = _Joined(parts)
    found = judge.answers(request, result, most=None)
    status = result.status
    return Measured(
        arm.name,
        kind,
        task,
        solver,
        rows,
        int((status == Status.CONVERGED).sum()),
        int((status == Status.OUT_OF_REACH).sum()),
        float(np.median(times)) * 1e6,
        float(result.iterations.mean()),
        Counter(fault.kind for fault in found),
        {fault.kind: f"row {fault.row}: {fault.text}" for fault in reversed(found)},
    )


def _push_out(arm: Arm, poses: Array, rng: np.random.Generator) -> None:
    """Move points beyond every constant length and slide added up."""
    slides = np.maximum(np.abs(arm.lower), np.abs(arm.upper))[~arm.turns].sum()
    reach = 1.01 * (arm.length + slides)
    way = rng.normal(size=(len(poses), 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    poses[:, :3, 3] = way * reach * rng.uniform(1.0, 3.0, (len(poses), 1))


class _Joined:
    """Results of pieces, put together."""

    def __init__(self, parts: list[Any]) -> None:
        for name in ("success", *judge.FIELDS):
            setattr(self, name, np.concatenate([np.asarray(getattr(p, name)) for p in parts]))

    status: np.ndarray
    iterations: np.ndarray
