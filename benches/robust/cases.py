"""One case of the fuzzer: an arm, a few requests to it, and all that must hold for the answers."""

from __future__ import annotations

import itertools
import pickle
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

import agrik_fast as ik
from agrik_fast import Status

from . import arms, building, judge, postures, requests
from .chain import Arm
from .judge import Fault
from .snippet import snippet

REQUESTS = 3
"""Requests to one arm."""

FIELDS_OF_BRANCHES = ("q", "valid", "reached", "singular", "status")
ALONE = 12
"""Rows of a call that are solved again one by one."""


@dataclass
class Outcome:
    """What a case found."""

    counts: Counter[str] = field(default_factory=Counter)
    tally: dict[str, list[float]] = field(default_factory=dict)
    """By "solver, task": rows, reachable rows, those of them solved, seconds."""
    faults: list[dict[str, Any]] = field(default_factory=list)

    def add(self, kind: str, text: str, number: int, place: str, code: str) -> None:
        self.counts[f"fault: {kind}"] += 1
        self.faults.append(
            {"kind": kind, "case": number, "place": place, "text": text, "code": code}
        )


Say = Callable[[str], None]
"""Tells the watchdog what is about to be called."""


def run(seed: int, number: int, say: Say = lambda doing: None) -> Outcome:
    """Do one case; everything follows from the seed and the case's number.

    Parameters
    ----------
    seed, number : int
        Which case, both >= 0.
    say : callable
        Told before each call into the library what it is.
    """
    warnings.simplefilter("ignore")
    outcome = Outcome()
    arm = arms.draw(_stream(seed, number))
    outcome.counts[f"arms: {arm.kind}"] += 1
    say(f"build {arm.kind}")
    try:
        robot = building.library_arm(arm)
    except ik.AgrikError as error:
        outcome.counts[f"refused arm: {type(error).__name__}"] += 1
        outcome.add("arm refused", str(error)[:300], number, arm.kind, snippet(arm))
        return outcome
    except BaseException as error:
        _reraise(error)
        outcome.add("exception", _named(error), number, arm.kind, snippet(arm))
        return outcome
    # Which value is whose is the library's to say; what it does is not.
    arm = arm.ordered(robot.joint_names)
    _same_arm(arm, robot, _stream(seed, number, 0), outcome, number)
    say("closed_form")
    family = robot.closed_form
    outcome.counts[f"family: {family}"] += 1
    for index in range(1, REQUESTS + 1):
        request = requests.draw(arm, family, _stream(seed, number, index))
        rng = _stream(seed, number, index, 1)
        _Asked(number, arm, robot, request, rng, outcome, say).run()
    return outcome


def _stream(*numbers: int) -> np.random.Generator:
    """Random numbers of their own for the arm, each request and its comparisons."""
    return np.random.Generator(np.random.PCG64(numbers))


def _same_arm(
    arm: Arm, robot: ik.Robot, rng: np.random.Generator, outcome: Outcome, number: int
) -> None:
    """Compare the library's kinematics with ours: a wrong judge would judge wrongly."""
    low, high = postures.bounds(arm)
    q = low + (high - low) * rng.random((20, arm.dof))
    ours, theirs = arm.fk(q), robot.fk(q)
    slip, turn_slip = arm.rounding(q)
    off = np.abs(ours - theirs)
    # Offsets below 1e-12 of the arm may be left out, one a joint and axis.
    left_out = 2e-12 * arm.length * len(arm.joints)
    wrong = (off[:, :3, 3].max(axis=1) > 8 * slip + left_out) | (
        off[:, :3, :3].max(axis=(1, 2)) > 8 * turn_slip
    )
    for row in np.flatnonzero(wrong)[:1]:
        text = f"q {q[row].tolist()}: differs by {off[row].max():.3e}"
        outcome.add("forward kinematics differ", text, number, arm.kind, snippet(arm))
    slack = np.where(arm.leads, 4 * judge.EPS * (1 + np.abs(arm.lower)), 0.0)
    with np.errstate(invalid="ignore"):
        ends = (np.abs(robot.lower - arm.lower) <= slack) | (robot.lower == arm.lower)
        ends &= (np.abs(robot.upper - arm.upper) <= slack) | (robot.upper == arm.upper)
    if not ends.all():
        text = f"{robot.lower.tolist()} to {robot.upper.tolist()}"
        outcome.add("limits differ", text, number, arm.kind, snippet(arm))


@dataclass
class _Asked:
    """One request, its answer and the comparisons."""

    number: int
    arm: Arm
    robot: ik.Robot
    request: requests.Request
    rng: np.random.Generator
    outcome: Outcome
    say: Say

    @property
    def place(self) -> str:
        request = self.request
        solver = request.solver
        shown = solver if isinstance(solver, str) else repr(solver)
        # Limits far out break many things at once; who reads wants to see the others.
        wide = f", limits of {self.arm.widest:.3g} rad" if self.arm.widest > 100 else ""
        return f"{self.arm.kind}{wide}, {request.task_name}, {shown[:160]}, {request.rows} rows"

    def run(self) -> None:
        request = self.request
        if request.refusal:
            # One row is enough to see that the refusal is a documented one.
            self._refused()
            return
        begin = time.perf_counter()
        threads = [None, 1, 2][self.rng.integers(3)]
        before = [None if a is None else a.tobytes() for a in (request.targets, request.q0)]
        result = self._call(request.piece(0, request.rows)(threads=threads))
        if result is None:
            return
        seconds = time.perf_counter() - begin
        after = [None if a is None else a.tobytes() for a in (request.targets, request.q0)]
        if before != after:
            self._add("input changed", 0, "targets or q0")
        self._count(result, seconds)
        check = judge.branches if request.solver_name == requests.BRANCHES else judge.answers
        for fault in check(request, result):
            self._fault(fault)
        if np.ndim(result.status) == 1:
            self._disprove(result)
        self._compare(result)

    def _disprove(self, result: Any) -> None:
        """Look for a solution of what is told to have none: another proof that none was."""
        request = self.request
        told = (np.asarray(result.status) == Status.OUT_OF_REACH) & ~request.reachable
        rows = np.flatnonzero(told)[:30]
        if not len(rows):
            return
        other = replace(
            request,
            solver="lm",
            solver_name="lm",
            task="pose" if request.solver_name == requests.BRANCHES else request.task,
            targets=request.targets[rows],
            poses=request.poses[rows],
            reachable=request.reachable[rows],
            made_from=request.made_from[rows],
            q0=None,
            options={k: v for k, v in request.options.items() if k != "arm_angle"},
        )
        self.say(f"{self.place}, lm on what is out of reach")
        self.outcome.counts["calls"] += 1
        self.outcome.counts["proofs tried"] += len(rows)
        try:
            found = self.robot.ik(**other.piece(0, len(rows))())
        except BaseException as error:
            _reraise(error)
            self._add("exception", 0, _named(error))
            return
        # Not its word but what it found: a posture within limits and tolerances by our own account.
        for i in np.flatnonzero(judge.solves(other, np.asarray(found.q)))[:1]:
            text = f"a solution is q {found.q[i].tolist()}"
            self._add("false proof", int(rows[i]), text)

    def _call(self, arguments: dict[str, Any], robot: ik.Robot | None = None) -> Any:
        """Ask the library; None after an exception, which is noted."""
        request = self.request
        robot = self.robot if robot is None else robot
        self.say(f"{self.place}, threads {arguments.get('threads')}")
        self.outcome.counts["calls"] += 1
        try:
            ask = robot.ik_all if request.solver_name == requests.BRANCHES else robot.ik
            return ask(**arguments)
        except ik.AgrikError as error:
            if not request.refusal:
                self._add("refused", 0, f"{type(error).__name__}: {str(error)[:300]}")
            else:
                self.outcome.counts[f"refused: {request.refusal}"] += 1
        except BaseException as error:
            _reraise(error)
            self._add("exception", 0, _named(error))
        return None

    def _refused(self) -> None:
        result = self._call(self.request.piece(0, 1)())
        if result is not None:
            # It was answered after all, so it must be right.
            self.outcome.counts[f"answered, though {self.request.refusal}"] += 1

    def _count(self, result: Any, seconds: float) -> None:
        request = self.request
        counts = self.outcome.counts
        counts["rows"] += request.rows
        status = np.asarray(result.status)
        for code, number in zip(*np.unique(status, return_counts=True), strict=True):
            counts[f"status: {Status(code).name}"] += int(number)
        solved = int(((status == Status.CONVERGED) & request.reachable).sum())
        name = f"{request.solver_name}, {request.task_name}"
        plain = isinstance(request.solver, str) and "position_tolerance" not in request.options
        self.outcome.tally[name if plain else f"{request.solver_name}, other options"] = [
            request.rows,
            int(request.reachable.sum()),
            solved,
            seconds,
        ]

    # -- the same bits, however it is asked ------------------------------------------------------

    def _compare(self, result: Any) -> None:
        request, rng = self.request, self.rng
        rows = request.rows
        fields = judge.FIELDS
        if request.solver_name == requests.BRANCHES:
            fields = FIELDS_OF_BRANCHES
        whole = request.piece(0, rows)
        if rng.random() < 0.5:
            self._agree(result, self._call(whole(threads=2)), slice(None), fields, "2 threads")
        if rng.random() < 0.3:
            self._agree(result, self._call(whole(threads=1)), slice(None), fields, "1 thread")
        if rng.random() < 0.3:
            anew = self._call(whole(), pickle.loads(pickle.dumps(self.robot)))
            self._agree(result, anew, slice(None), fields, "a robot made anew")
        if rows > 1 and rng.random() < 0.5:
            cuts = [0, *np.sort(rng.integers(0, rows + 1, 2)).tolist(), rows]
            for begin, end in itertools.pairwise(cuts):
                if end > begin:
                    piece = self._call(request.piece(begin, end)(threads=1))
                    place = f"rows {begin} to {end} of {rows}"
                    self._agree(result, piece, slice(begin, end), fields, place)
        for row in rng.permutation(rows)[:ALONE].tolist():
            alone = self._call(request.piece(row, row + 1)())
            self._agree(result, alone, slice(row, row + 1), fields, f"row {row} alone")
        if isinstance(request.solver, str | ik.solvers.LevenbergMarquardt):
            self._loop()
        if request.solver_name != requests.BRANCHES and rng.random() < 0.2:
            self._stream(result)
        if request.solver == "lm" and request.task_name != "masked" and rng.random() < 0.5:
            self._follow()

    def _stream(self, result: Any) -> None:
        """Compare `Robot.ik_stream`, whose start values are the same for all targets."""
        request = self.request
        if request.q0 is not None and request.q0.ndim == 2:
            return
        given = request.piece(0, request.rows)()
        targets = given.pop("targets")
        self.say(f"{self.place}, ik_stream")
        self.outcome.counts["calls"] += 1
        try:
            for at, part in zip(
                np.array_split(np.arange(request.rows), 3),
                self.robot.ik_stream(np.array_split(targets, 3), **given),
                strict=True,
            ):
                if len(at):
                    rows = slice(int(at[0]), int(at[-1]) + 1)
                    self._agree(result, part, rows, judge.FIELDS, "ik_stream")
        except BaseException as error:
            _reraise(error)
            self._add("exception", 0, f"ik_stream: {_named(error)}")

    def _follow(self) -> None:
        """Follow some of the targets: what is told as reached is, and jumps are told."""
        request = self.request
        part = replace(
            request,
            solver_name="follow",
            targets=request.targets[:12],
            poses=request.poses[:12],
            reachable=np.zeros(min(request.rows, 12), bool),
            made_from=request.made_from[:12],
            q0=None,
        )
        options = {k: v for k, v in request.options.items() if k != "first_index"}
        stands = np.clip(request.made_from[0], self.robot.lower, self.robot.upper)
        step = float(self.rng.choice([1e-3, 0.1, 10.0]))
        self.say(f"{self.place}, follow")
        self.outcome.counts["calls"] += 1
        try:
            path = self.robot.follow(part.targets, stands, step, task=request.task, **options)
        except BaseException as error:
            _reraise(error)
            self._add("exception", 0, f"follow: {_named(error)}")
            return
        self.outcome.counts["rows"] += part.rows
        shown = dict.fromkeys(("turn further than need be", "solution not claimed"), True)
        for fault in judge.answers(part, _Followed(path)):
            # The way decides which turn it is; a jump may be told instead of a solution.
            if fault.kind not in shown:
                self._add(fault.kind, fault.row, f"follow: {fault.text}")
        # Too fast a path says so; how far the first row is from where the arm stands is nobody's.
        steps = np.abs(np.diff(np.vstack([path.q[:1], path.q]), axis=0))
        slack = 4 * judge.EPS * (1 + np.abs(path.q))
        told = path.discontinuity | path.too_fast
        far = (steps > step + slack).any(axis=1) & ~told & path.success
        for row in np.flatnonzero(far)[:1]:
            text = f"follow: step of {steps[row].max()!r}, at most {step}, no discontinuity told"
            self._add("jump not told", int(row), text)

    def _agree(
        self, result: Any, other: Any, rows: slice, fields: tuple[str, ...], how: str
    ) -> None:
        if other is None:
            return
        agrees = judge.same(_Part(result, rows, fields), other, fields)
        self.outcome.counts["rows compared"] += len(agrees)
        for row in np.flatnonzero(~agrees)[:1]:
            at = int(row) + (rows.start or 0)
            parts = ", ".join(_difference(result, other, at, int(row), fields))
            self._add("bits differ", at, f"{how}: {parts}")

    def _loop(self) -> None:
        """Compare `Robot.solver`, one object for several targets, with calls of one row."""
        request = self.request
        if request.solver_name in ("auto", "closed_form", "de", "ga", requests.BRANCHES):
            return
        options = {k: v for k, v in request.options.items() if k != "first_index"}
        self.say(f"{self.place}, solver()")
        try:
            loop = self.robot.solver(task=request.task, solver=request.solver, **options)
        except ik.AgrikError as error:
            self._add("refused", 0, f"solver(): {str(error)[:300]}")
            return
        except BaseException as error:
            _reraise(error)
            self._add("exception", 0, f"solver(): {_named(error)}")
            return
        starts = request.starts()
        for row in self.rng.permutation(request.rows)[:6].tolist():
            arguments = request.piece(row, row + 1)() | {"first_index": 0}
            alone = self._call(arguments)
            if alone is None:
                return
            self.say(f"{self.place}, solver().solve")
            try:
                loop.solve(request.targets[row], None if starts is None else starts[row])
            except BaseException as error:
                _reraise(error)
                self._add("exception", row, f"solve(): {_named(error)}")
                return
            self.outcome.counts["rows compared"] += 1
            one = _Part(alone, slice(0, 1), judge.FIELDS)
            wrong = [
                name
                for name in judge.FIELDS
                if np.asarray(getattr(loop, name), getattr(one, name).dtype).tobytes()
                != getattr(one, name).tobytes()
            ]
            if wrong:
                text = f"solver(): {', '.join(wrong)}; {loop.q.tolist()} not {one.q[0].tolist()}"
                self._add("bits differ", row, text)
                return

    # -- faults ----------------------------------------------------------------------------------

    def _fault(self, fault: Fault) -> None:
        self._add(fault.kind, fault.row, fault.text)

    def _add(self, kind: str, row: int, text: str) -> None:
        code = snippet(self.arm, self.request, row)
        self.outcome.add(kind, f"row {row}: {text}", self.number, self.place, code)


class _Followed:
    """A path as the record of `ik`; it does not count restarts."""

    def __init__(self, path: Any) -> None:
        for name in ("q", "success", "status", "position_error", "orientation_error"):
            setattr(self, name, np.asarray(getattr(path, name)))


class _Part:
    """Some rows of a result, flattened to one row a target."""

    def __init__(self, result: Any, rows: slice, fields: tuple[str, ...]) -> None:
        for name in fields:
            setattr(self, name, np.asarray(getattr(result, name))[rows])


def _difference(
    result: Any, other: Any, at: int, row: int, fields: tuple[str, ...]
) -> Iterator[str]:
    for name in fields:
        one, two = np.asarray(getattr(result, name))[at], np.asarray(getattr(other, name))[row]
        if one.tobytes() != two.tobytes():
            yield f"{name} {one.tolist()} not {two.tolist()}"


def _named(error: BaseException) -> str:
    return f"{type(error).__module__}.{type(error).__name__}: {str(error)[:300]}"


def _reraise(error: BaseException) -> None:
    """Let through what ends the process."""
    if isinstance(error, KeyboardInterrupt | SystemExit | MemoryError):
        raise error
