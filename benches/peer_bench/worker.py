"""One library in one process: reads commands as JSON lines, answers with measurements.

Run as ``python -m peer_bench.worker MODULE CPU`` by the library's own interpreter; CPU is the core
to stay on, or -1 for all. Garbage collection is off while the clock runs. Times of solves are
process CPU time, because some libraries solve on a thread of their own; the cost of reading the
clock is subtracted.
"""

from __future__ import annotations

import gc
import importlib
import json
import os
import sys
import tempfile
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from .adapters import Evaluation, Solver
from .robots import load_robots, solved, targets, urdf_text

WARM_UP_SOLVES = 5
RATE_BUDGET_NS = 20_000_000

cpu_clock = time.process_time_ns
wall_clock = time.perf_counter_ns


class Worker:
    def __init__(self, module: str, folder: Path) -> None:
        self.adapter = importlib.import_module(f".adapters.{module}", __package__)
        self.folder = folder
        self.robots = load_robots()
        self.solver: Solver | None = None
        self.natives: list[Any] = []
        self.clock_cost = min(_clock_cost() for _ in range(5))

    def about(self) -> dict[str, Any]:
        notes = getattr(self.adapter, "native_notes", None)
        return {
            "version": version(self.adapter.DISTRIBUTION),
            "python": sys.version.split()[0],
            "numpy": np.__version__,
            "notes": notes() if notes else "",
        }

    def _urdf(self, robot: str) -> str:
        path = self.folder / f"{robot}.urdf"
        if not path.exists():
            path.write_text(urdf_text(self.robots[robot]))
        return str(path)

    def open(
        self, robot: str, count: int, position_only_m: float | None, what: str = "pose"
    ) -> dict[str, Any]:
        """Prepare `count` targets of a robot for single solves."""
        make = getattr(self.adapter, what if position_only_m is None else "position", None)
        arguments = () if position_only_m is None else (position_only_m,)
        self.robot = self.robots[robot]
        self.position_only_m = position_only_m
        self.solver = make(self.robot, self._urdf(robot), *arguments) if make else None
        if self.solver is None:
            return {"able": False}
        self.q, self.poses, self.starts = targets(self.robot, count)
        self.natives = [self.solver.prepare(pose) for pose in self.poses]
        return {
            "able": True,
            "settings": self.solver.settings,
            "batch": self.solver.batch is not None,
        }

    def solve(self, begin: int, end: int) -> dict[str, Any]:
        """Single solves of targets begin..end: CPU and wall nanoseconds each, and success."""
        assert self.solver is not None
        call, natives, starts = self.solver.solve, self.natives, self.starts
        for i in range(begin - WARM_UP_SOLVES, begin):
            call(natives[i], starts[i])
        cpu, wall, answers = [], [], []
        gc.disable()
        for i in range(begin, end):
            target, start = natives[i], starts[i]
            w = wall_clock()
            c = cpu_clock()
            answer = call(target, start)
            c = cpu_clock() - c
            wall.append(wall_clock() - w)
            cpu.append(max(c - self.clock_cost, 0))
            answers.append(answer)
        gc.enable()
        ok = [self._judge(answer, begin + i) for i, answer in enumerate(answers)]
        return {"cpu_ns": cpu, "wall_ns": wall, "ok": ok}

    def in_a_row(self, begin: int, end: int) -> dict[str, Any]:
        """CPU nanoseconds of a solve in a loop of nothing else.

        Reading the clock of CPU time is a system call. After one, calls of a microsecond or
        two take twice as long as they do in a loop.
        """
        assert self.solver is not None
        pairs = list(zip(self.natives[begin:end], self.starts[begin:end], strict=True))
        spent = _spent(self.solver.solve, pairs) - _spent(_no_solve, pairs)
        return {"cpu_ns": max(spent, 0) / len(pairs)}

    def _judge(self, answer: Any, index: int) -> bool:
        assert self.solver is not None
        if answer is None or len(answer) == 0:
            return False
        q = np.atleast_2d(np.asarray(answer, float))
        if self.solver.every_solution:
            q = self.robot.wrapped(q)
        wanted = np.broadcast_to(self.poses[index], (len(q), 4, 4))
        return bool(solved(self.robot, q, wanted, self.position_only_m).any())

    def overhead(self, count: int) -> dict[str, Any]:
        """Wall and CPU nanoseconds of calls that start at a solution."""
        assert self.solver is not None
        assert self.solver.overhead is not None
        call, gaps = self.solver.overhead, []
        pairs = list(zip(self.poses[:count], self.q[:count], strict=True))
        gc.disable()
        for target, q in pairs:
            w = wall_clock()
            call(target, q)
            gaps.append(wall_clock() - w)
        gc.enable()
        return {"wall_ns": gaps}

    def first_call(self, robot: str) -> dict[str, Any]:
        """Wall nanoseconds of loading a robot and of its first solve, in a fresh process."""
        _, poses, _ = targets(self.robots[robot], 1)
        begin = wall_clock()
        solver: Solver = self.adapter.pose(self.robots[robot], self._urdf(robot))
        loaded = wall_clock()
        solver.solve(poses[0], poses[0])
        return {"load_ns": loaded - begin, "solve_ns": wall_clock() - loaded}

    def batch(self, count: int, threads: int) -> dict[str, Any]:
        """One batch call: CPU and wall nanoseconds a target, and how many were solved."""
        assert self.solver is not None
        assert self.solver.batch is not None
        _, poses, _ = targets(self.robot, count)
        self.solver.batch(poses[:100], threads)
        gc.disable()
        w, c = wall_clock(), cpu_clock()
        result = self.solver.batch(poses, threads)
        c, w = cpu_clock() - c, wall_clock() - w
        gc.enable()
        q, claimed = self.solver.unpack(result)
        claimed = np.asarray(claimed)
        good = claimed & solved(self.robot, q, poses, self.position_only_m)
        return {
            "cpu_ns": c / count,
            "wall_ns": w / count,
            "solved": int(good.sum()),
            "claimed": int(claimed.sum()),
            "n": count,
        }

    def products(self, seconds: float) -> dict[str, Any]:
        """Products of small matrices a second: work that shares nothing but the machine."""
        a, out = np.full((64, 64), 0.5), np.empty((64, 64))
        begin, done = wall_clock(), 0
        end = begin + int(1e9 * seconds)
        while wall_clock() < end:
            for _ in range(20):
                np.matmul(a, a, out=out)
            done += 20
        return {"rate": 1e9 * done / (wall_clock() - begin)}

    def branches(self) -> dict[str, Any]:
        """Solutions of each target, limits aside."""
        assert self.solver is not None
        assert self.solver.count is not None
        return {"counts": [self.solver.count(native) for native in self.natives]}

    def memory(self, robot: str, count: int) -> dict[str, Any]:
        """Bytes in, bytes out and the rise of resident memory of one batch call."""
        _, poses, _ = targets(self.robots[robot], min(count, 10_000))
        poses = np.ascontiguousarray(np.resize(poses, (count, 4, 4)))
        self.adapter.batch_arrays(self.robots[robot], poses[:100])
        before = _resident_bytes("VmRSS")
        Path("/proc/self/clear_refs").write_text("5")  # the peak starts anew
        outputs = self.adapter.batch_arrays(self.robots[robot], poses)
        peak = _resident_bytes("VmHWM")
        return {
            "n": count,
            "inputs": poses.nbytes,
            "outputs": sum(array.nbytes for array in outputs),
            "rise": peak - before,
        }

    def evaluate(self, what: str, robot: str, batch: int) -> dict[str, Any]:
        """FK or Jacobian calls: CPU nanoseconds a configuration, and the FK's largest error."""
        make = getattr(self.adapter, f"{what}_batch" if batch else what, None)
        if make is None:
            return {"able": False}
        item: Evaluation = make(self.robots[robot], self._urdf(robot))
        q, poses, _ = targets(self.robots[robot], max(batch, 200))
        arguments = [q[:batch]] if batch else [np.ascontiguousarray(row) for row in q[:200]]
        worst = None
        if item.as_pose is not None:
            got = item.as_pose(item.call(arguments[0]))
            wanted = poses[:batch] if batch else poses[0]
            worst = float(np.abs(got - wanted).max())
        per_call = _nanoseconds_a_call(item.call, arguments)
        return {
            "able": True,
            "note": item.note,
            "cpu_ns": per_call / max(batch, 1),
            "worst_error": worst,
        }


def _resident_bytes(field: str) -> int:
    """Read VmRSS (now) or VmHWM (peak) of this process, Linux only."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(field + ":"):
            return 1024 * int(line.split()[1])
    raise OSError(f"no {field} in /proc/self/status")


def _clock_cost() -> float:
    begin = cpu_clock()
    for _ in range(200):
        cpu_clock()
    return (cpu_clock() - begin) / 201


def _nanoseconds_a_call(call: Callable[[Any], Any], arguments: list[Any]) -> float:
    """CPU time of a call, with the loop's own cost subtracted."""
    begin = cpu_clock()
    for argument in arguments:
        call(argument)
    once = max((cpu_clock() - begin) / len(arguments), 50.0)
    count = max(1, min(100_000, int(RATE_BUDGET_NS / once)))
    work = [arguments[i % len(arguments)] for i in range(count)]
    gc.disable()
    spent, empty = _loop(call, work), _loop(_nothing, work)
    gc.enable()
    return max(spent - empty, 0.0) / count


def _loop(call: Callable[[Any], Any], work: list[Any]) -> float:
    begin = cpu_clock()
    for argument in work:
        call(argument)
    return cpu_clock() - begin


def _nothing(argument: Any) -> None:
    return None


def _spent(solve: Callable[[Any, Any], Any], pairs: list[tuple[Any, Any]]) -> int:
    gc.disable()
    begin = cpu_clock()
    for target, start in pairs:
        solve(target, start)
    spent = cpu_clock() - begin
    gc.enable()
    return spent


def _no_solve(target: Any, start: Any) -> None:
    return None


def main() -> None:
    module, cpu = sys.argv[1], int(sys.argv[2])
    if cpu >= 0 and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {cpu})
    # Libraries print; keep the answers' channel to ourselves.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    with tempfile.TemporaryDirectory() as folder:
        worker = Worker(module, Path(folder))
        for line in sys.stdin:
            command = json.loads(line)
            try:
                answer = getattr(worker, command.pop("op"))(**command)
            except Exception as error:
                answer = {"error": f"{type(error).__name__}: {error}"[:500]}
            answers.write(json.dumps(answer) + "\n")
            answers.flush()


if __name__ == "__main__":
    main()
