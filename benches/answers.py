"""Hashes of answers, so that two builds can be compared bit for bit.

    python benches/answers.py -o old.json         # with the old build
    python benches/answers.py --compare old.json  # with the new one: exit status 1 if they differ

Every solver with its options, on every bundled robot and a gantry, for every task, in batches and
single calls, at every instruction set of the machine; besides kinematics, branches of the closed
forms, paths, streams, tuned gains and the two arms that have classes of their own. To ask another
checkout's build, set PYTHONPATH to its folder `python`. Bits may differ between machines, whose
processors and mathematical libraries do: compare two builds on one.
"""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import itertools
import json
import os
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import agrik_fast as ik
from agrik_fast import solvers, tasks

try:
    from agrik_fast import arms as own_arms
except ImportError:  # where older builds have them
    from agrik_fast import closed_form as own_arms
try:
    from agrik_fast.tuning import Tuning, tune
except ImportError:
    from agrik_fast.tune import Tuning, tune

LEVELS = ("scalar", "neon", "avx2", "avx512")
REACHABLE = 66  # with three more no multiple of a number of lanes
SINGLES = 9
FIELDS = (
    *("q", "success", "status", "position_error", "orientation_error", "iterations", "restarts"),
    *("valid", "reached", "singular", "discontinuity", "joint_step"),
    *("energy", "place", "gap", "outcome", "branch", "reason"),
)


def digest(*values: Any) -> str:
    """Return a hash of arrays, numbers and words, their shapes and types included."""
    state = hashlib.blake2b(digest_size=12)
    for value in values:
        array = np.asarray(value)
        state.update(f"{array.dtype.str}{array.shape};".encode())
        state.update(np.ascontiguousarray(array).tobytes())
    return state.hexdigest()


def of_result(*results: Any) -> str:
    """Return a hash of the fields that results have, and how many targets are solved."""
    fields = [name for name in FIELDS if hasattr(results[0], name)]
    values = [getattr(result, name) for result in results for name in fields]
    named = digest(",".join(fields), *values)
    told = [
        np.asarray(result.success if hasattr(result, "success") else result.valid)
        for result in results
    ]
    return f"{named} {sum(int(one.sum()) for one in told)}/{sum(one.size for one in told)}"


def gantry() -> ik.Robot:
    """A robot with prismatic joints: three slides and three turns."""
    quarter = np.pi / 2
    rows = [
        [0, -quarter, 0, 0],
        [0, quarter, 0, quarter],
        [0, 0, 0, 0],
        [0, quarter, 0, 0],
        [0, -quarter, 0, 0],
        [0.1, 0, 0.1, 0],
    ]
    kinds = ["prismatic"] * 3 + ["revolute"] * 3
    limits = [(0, 1)] * 3 + [(-2.5, 2.5)] * 3
    return ik.Robot.from_dh(rows, joint_types=kinds, limits=limits, name="gantry")


def robots() -> list[ik.Robot]:
    """The bundled robots and the gantry."""
    return [*(ik.Robot.load(name) for name in ik.Robot.names()), gantry()]


def targets_of(arm: ik.Robot) -> np.ndarray:
    """Poses: most of them reachable, then one out of reach, one near it, and one that is NaN."""
    poses = arm.fk(arm.random_q(REACHABLE + 3, seed=5))
    far, near, missing = poses[-3:]
    far[:3, 3] = [30.0, -20.0, 10.0]
    near[:3, 3] = 0.97 * arm.reach_radius * near[:3, 3] / np.linalg.norm(near[:3, 3])
    missing[0, 3] = np.nan
    return poses


def every_task() -> dict[str, tuple[Any, bool]]:
    """Tasks by name, and whether they take positions."""
    return {
        "position": (tasks.Position(), True),
        "pose": (None, False),
        "axis": (tasks.Axis((1, 0, 0)), False),
        "axis down": (tasks.Axis((0, 0, 1), (0, 0, -1)), True),
        "masked base": (tasks.Masked((1, 1, 1, 0, 0, 1)), False),
        "masked tool": (tasks.Masked((1, 0.5, 1, 0.2, 0, 0), frame="tool"), False),
    }


def plain_solvers() -> dict[str, Any]:
    """Every solver with its defaults, but for caps that keep hopeless searches short."""
    short = {"max_restarts": 3}
    return {
        "lm": "lm",
        "auto": "auto",
        "closed_form": "closed_form",
        "dls": solvers.DampedLeastSquares(**short),
        "pinv": solvers.PseudoInverse(**short),
        "pinv-closed": solvers.ClosedPseudoInverse(**short),
        "transpose": solvers.Transpose(max_iterations=300, **short),
        "ccd": solvers.CyclicCoordinateDescent(max_iterations=60, **short),
        "ik-pid": solvers.IkPid(max_iterations=60, **short),
        "state-space": solvers.StateSpace(max_iterations=150, **short),
        "static-gain": solvers.StaticGain(max_iterations=150, **short),
        "broyden": solvers.Broyden(**short),
        "de": solvers.DifferentialEvolution(max_restarts=1),
        "ga": solvers.GeneticAlgorithm(max_restarts=1),
    }


def options_of_solvers(arm: ik.Robot, rows: int) -> dict[str, Any]:
    """Options that `plain_solvers` leaves at their defaults; `rows` is the length of the error."""
    once = {"max_restarts": 0}
    gain = 0.2 * np.linalg.pinv(arm.jacobian(arm.random_q(seed=3))[:rows], rcond=0.1)
    system = {"A": 0.3 * np.eye(rows), "B": 0.7 * np.eye(rows), "C": gain, "max_iterations": 80}
    found: dict[str, Any] = {
        "lm, damping": solvers.LevenbergMarquardt(damping=0.5, max_step=0.2, max_iterations=20),
        "closed_form, margin": solvers.ClosedForm(choose="margin"),
        "closed_form, middle": solvers.ClosedForm(choose="middle"),
        "closed_form, arm angle": solvers.ClosedForm(arm_angle=0.4),
        "closed_form, certify": solvers.ClosedForm(certify=True),
        "ccd, zero": solvers.CyclicCoordinateDescent(start="zero", max_iterations=40, **once),
        "ik-pid, literal": solvers.IkPid(ki=1e-7, literal=True, max_iterations=30, **once),
        "ik-pid, whole passes": solvers.IkPid(incremental=False, max_iterations=30, **once),
        "ik-pid, base first": solvers.IkPid(order="base-first", max_iterations=30, **once),
        "state-space, matrices": solvers.StateSpace(**system, **once),
        "static-gain, matrix": solvers.StaticGain(K=gain, max_iterations=80, **once),
        "broyden, matrix": solvers.Broyden(K=gain, patience=4, **once),
        "de, paper": dataclasses.replace(solvers.DifferentialEvolution.paper(), generations=10),
    }
    for start, step in itertools.product(
        ("sampled", "zero", "middle"), (solvers.PseudoInverse(), solvers.Transpose())
    ):
        plain = solvers.Plain(solver=step, start=start, max_iterations=60)
        found[f"plain {step.name}, {start}"] = plain
    search = {"population": 20, "generations": 12, **once}
    for mutation, adaptation in itertools.product(
        ("best1", "rand1", "current-to-best1"), ("none", "jde", "lshade")
    ):
        found[f"de, {mutation}, {adaptation}"] = solvers.DifferentialEvolution(
            mutation=mutation, adaptation=adaptation, **search
        )
    for boundary in ("median", "clamp", "reflect", "redraw"):
        for kind in (solvers.DifferentialEvolution, solvers.GeneticAlgorithm):
            found[f"{kind.name}, {boundary}, Euler"] = kind(
                boundary=boundary, orientation="euler-zyz", polish=False, **search
            )
    for redraw in ("gene", "generation"):
        found[f"de, {redraw}"] = solvers.DifferentialEvolution(
            redraw=redraw, stagnation=4, start_weight=0.1, **search
        )
    return found


Work = tuple[str, Callable[[], str]]


def kinematics(arm: ik.Robot) -> Iterator[Work]:
    q = arm.random_q((5, 7), seed=1)
    yield "fk", lambda: digest(arm.fk(q), arm.fk(q[0, 0]), arm.fk_links(q))
    yield "jacobian", lambda: digest(arm.jacobian(q), arm.jacobian(q[0, 0]))
    yield "reach", lambda: digest(arm.reach_radius, arm.reach_center, arm.reach_box)
    if arm.closed_form == "S-R-S":
        yield "arm angle", lambda: digest(arm.arm_angle(q))
        some = arm.fk(q[0])
        yield (
            "arm angle intervals",
            lambda: digest(*itertools.chain(*map(arm.arm_angle_intervals, some))),
        )


def tool() -> np.ndarray:
    """A tool behind the robot's own: a turn about y and a shift."""
    pose = np.eye(4)
    pose[:3, :3] = [[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]]
    pose[:3, 3] = [0.02, -0.01, 0.05]
    return pose


def inverse(arm: ik.Robot) -> Iterator[Work]:
    poses = targets_of(arm)
    starts = arm.random_q(len(poses), seed=9)
    for (task_name, (task, points)), (name, solver) in itertools.product(
        every_task().items(), plain_solvers().items()
    ):
        targets = poses[:, :3, 3] if points else poses
        options = {"task": task, "solver": solver}
        yield f"{task_name}, {name}", lambda t=targets, o=options: of_result(arm.ik(t, seed=2, **o))
        yield (
            f"{task_name}, {name}, single",
            lambda t=targets, o=options: of_result(*(arm.ik(one, **o) for one in t[:SINGLES])),
        )
        yield (
            f"{task_name}, {name}, start and tool",
            lambda t=targets, o=options: of_result(
                arm.ik(t[:19], q0=starts[:19], tool=tool(), threads=1, first_index=3, **o),
                arm.ik(t[0], q0=starts[0], tool=tool(), **o),
            ),
        )
        yield (
            f"{task_name}, {name}, in a loop",
            lambda t=targets, o=options: in_a_loop(arm, t[:SINGLES], starts[0], o),
        )
    for task_name, points in (("position", True), ("pose", False)):
        targets = (poses[:, :3, 3] if points else poses)[:21]
        for name, solver in options_of_solvers(arm, 3 if points else 6).items():
            yield (
                f"{task_name}, {name}",
                lambda t=targets, s=solver: of_result(
                    arm.ik(t, solver=s, seed=4),
                    arm.ik(t[0], solver=s),
                    arm.ik(t[1], solver=s, q0=starts[1]),
                ),
            )
        yield (
            f"{task_name}, tolerances",
            lambda t=targets: of_result(
                arm.ik(t, position_tolerance=1e-3, orientation_tolerance=1e-2),
                arm.ik(t, position_tolerance=1e-9, orientation_tolerance=1e-9, solver="dls"),
            ),
        )
        for name in ("de", "ga"):
            yield (
                f"{task_name}, {name}, cost history",
                lambda t=targets, s=name: digest(arm.cost_history(t[0], s)),
            )
        pieces = (targets[:4], targets[4:5], targets[5:])
        yield (
            f"{task_name}, stream",
            lambda p=pieces: of_result(*arm.ik_stream(p, seed=6, first_index=2)),
        )


def in_a_loop(arm: ik.Robot, targets: np.ndarray, start: np.ndarray, options: Any) -> str:
    """Hash what a solver object answers, each target from the answer before."""
    loop = arm.solver(**options)
    values: list[Any] = []
    for target in targets:
        loop.solve(target, start)
        values += [np.array(loop.q), loop.success, loop.status, loop.position_error]
        values += [loop.orientation_error, loop.iterations, loop.restarts]
        start = np.array(loop.q)
    return digest(*values)


def branches_and_paths(arm: ik.Robot) -> Iterator[Work]:
    poses = targets_of(arm)
    starts = arm.random_q(len(poses), seed=9)
    if arm.closed_form is not None:
        yield "branches", lambda: of_result(arm.ik_all(poses))
        yield "branches, single", lambda: of_result(*map(arm.ik_all, poses[:SINGLES]))
        yield "branches, start", lambda: of_result(arm.ik_all(poses, q0=starts, threads=1))
        yield "branches, tool", lambda: of_result(arm.ik_all(poses, tool=tool()))
        folded = arm.fk(np.clip(np.zeros((1, arm.dof)), arm.lower, arm.upper))
        yield "branches, singular", lambda: of_result(arm.ik_all(folded), arm.ik_all(folded[0]))
        yield "branches, arm angle", lambda: of_result(arm.ik_all(poses, arm_angle=0.7))
    ends = arm.random_q(2, seed=12)
    share = np.linspace(0, 1, 40)[:, None]
    line = arm.fk(ends[0] + share * (ends[1] - ends[0]))
    jump = np.concatenate([line[:20], line[30:]])
    for name, targets in (("pose", line), ("position", line[:, :3, 3]), ("jump", jump)):
        yield (
            f"path, {name}",
            lambda t=targets: of_result(
                arm.follow(t, q0=ends[0]), arm.follow(t, max_joint_step=0.02, pull=0.1)
            ),
        )
    yield "path, axis", lambda: of_result(arm.follow(line, q0=ends[0], task=tasks.Axis()))


def strawberry() -> Iterator[Work]:
    arm = own_arms.StrawberryArm()
    low, high = np.array(arm.target_box)
    drawn = np.random.Generator(np.random.PCG64(7)).random((40, 3))
    points = low - 0.1 * (high - low) + 1.2 * (high - low) * drawn
    points[-1, 1] = np.nan
    for method in ("exact", "as", "ssas"):
        for rule in ("least_magnitude", "middle"):
            yield (
                f"{method}, {rule}",
                lambda m=method, r=rule: of_result(arm.solve(points, m, theta_rule=r)),
            )
        yield f"{method}, single", lambda m=method: of_result(arm.solve(points[0], m))
    q = np.array(arm.solve(points[:-1]).q)
    yield "fk and energy", lambda: digest(arm.fk(q), arm.energy(q), arm.reset_pose)
    yield "base shift", lambda: digest(arm.suggest_base_shift(points))
    yield "commands", lambda: digest(str(arm.commands(q[0])))
    yield "sets", lambda: digest(*(repr(arm.s10_set(p)) for p in points[:-1]))


def tomato() -> Iterator[Work]:
    free = own_arms.TomatoArm(lower=[-np.pi] * 3, upper=[np.pi] * 3)
    q = np.random.Generator(np.random.PCG64(8)).uniform(-1.2, 1.2, (40, 3))
    points = free.fk(q)
    points[-2] *= 5
    points[-1, 1] = np.nan
    for name, arm in (("free", free), ("servos", own_arms.TomatoArm())):
        yield f"{name}, solve", lambda a=arm: of_result(a.solve(points))
        yield f"{name}, follow", lambda a=arm: of_result(a.solve(points[:20], follow=True))
        yield f"{name}, single", lambda a=arm: of_result(a.solve(points[0]))
        for branch in range(4):
            yield (
                f"{name}, branch {branch}",
                lambda a=arm, b=branch: of_result(a.solve(points, branch=b)),
            )
        yield (
            f"{name}, branches",
            lambda a=arm: digest(*(np.asarray(x) for x in a.branches(points))),
        )
        yield (
            f"{name}, kinematics",
            lambda a=arm: digest(a.fk(q), a.jacobian(q), a.transpose_bound(q)),
        )
        for method in ("inverse", "pinv", "transpose", "dls"):
            yield (
                f"{name}, {method}",
                lambda a=arm, m=method: of_result(
                    a.iterate(points, m, q0=q[::-1], max_iterations=300)
                ),
            )


def numbers_of(gains: Any) -> list[Any]:
    """Return the numbers that a tuner finds, of whichever solver."""
    names = ("kp", "ki", "kd", "A", "B", "C", "K")
    return [value for name in names if (value := getattr(gains, name, None)) is not None]


def gains() -> Iterator[Work]:
    arm = ik.Robot.load("hydrolek")
    short = {"goals": 60, "evaluations": 150, "runs": 1, "refinement": 40, "max_iterations": 100}
    for solver, method in itertools.product(
        ("state-space", "static-gain", "ik-pid"), ("pso", "cma")
    ):
        search = Tuning(solver=solver, method=method, **short)
        yield f"{solver}, {method}", lambda t=search: digest(*numbers_of(tune(arm, t).make()))


def all_work() -> Iterator[Work]:
    for arm in robots():
        for part in (kinematics, inverse, branches_and_paths):
            for name, work in part(arm):
                yield f"{arm.name}: {name}", work
    others = {"StrawberryArm": strawberry, "TomatoArm": tomato, "tuned gains": gains}
    for title, parts in others.items():
        for name, work in parts():
            yield f"{title}: {name}", work


def answers() -> dict[str, str]:
    """Return a hash for every piece of work; where it is refused, the class of the refusal."""
    found: dict[str, str] = {}
    for name, work in all_work():
        if name in found:
            raise ValueError(f"two pieces of work are called {name!r}")
        try:
            found[name] = work()
        except ik.AgrikError as refusal:
            found[name] = f"refused: {type(refusal).__name__}"
    return found


def at_level(level: str, *words: str) -> str:
    """Return what this script prints with an instruction set."""
    environment = {**os.environ, "AGRIK_SIMD": level}
    command = [sys.executable, "-W", "ignore", __file__, *words]
    done = subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE, text=True)
    return done.stdout


def compare(before: dict[str, str], now: dict[str, str]) -> list[str]:
    """Return what differs, a line each; what only one machine's level has counts as well."""
    lines = []
    for name in sorted(before.keys() | now.keys()):
        old, new = before.get(name, "not asked"), now.get(name, "not asked")
        if old != new:
            lines.append(f"{name}\n    before: {old}\n    now:    {new}")
    return lines


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, help="write the hashes")
    parser.add_argument("--compare", type=Path, help="hashes of another build")
    parser.add_argument("--levels", help="comma-separated; default all that the machine has")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--level", action="store_true", help="print the level in use, and end")
    options = parser.parse_args()
    if options.level:
        print(ik.simd_level())
        return 0
    if options.worker:
        warnings.simplefilter("ignore")
        json.dump(answers(), sys.stdout)
        return 0
    levels = [name for name in LEVELS if at_level(name, "--level").strip() == name]
    if options.levels:
        wanted = options.levels.split(",")
        if missing := set(wanted) - set(levels):
            sys.exit(f"this machine lacks {', '.join(sorted(missing))}; it has {', '.join(levels)}")
        levels = wanted
    found: dict[str, str] = {}
    for level in levels:
        one = json.loads(at_level(level, "--worker"))
        print(f"{level}: {len(one)} hashes, together {digest(json.dumps(one))}")
        found |= {f"{level}: {name}": value for name, value in one.items()}
    if options.output:
        options.output.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    if options.compare is None:
        return 0
    before = json.loads(options.compare.read_text(encoding="utf-8"))
    if options.levels:
        before = {name: v for name, v in before.items() if name.split(":")[0] in levels}
    lines = compare(before, found)
    print(*lines, sep="\n", end="\n" if lines else "")
    print(f"{len(lines)} of {len(before.keys() | found.keys())} differ")
    return bool(lines)


if __name__ == "__main__":
    sys.exit(main())
