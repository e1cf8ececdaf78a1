"""All branches of many arms: what is missed, what is false, and how long it takes.

Postures uniform in -pi to pi make the poses; a posture that is not among the branches of its
pose within 1e-5 rad is missed. Every branch is held against forward kinematics. With `--starts`
the branches of a few poses are held against many starts of the numeric solver, which also
notices pairs that are missed together. Peers are timed in the same run where they are installed
(``eaik``, ``ssik``: see `requirements/`). One thread; CPU time.

    .venv/bin/python benches/branches.py --poses 2000
    .venv/bin/python benches/branches.py --poses 100000 --starts 200 --json branches.json

With `--check` it ends with status 1 where an arm misses more than is allowed: nothing with a
closed form, one in 10,000 with the general way, three with a nearly spherical wrist, and never
a false branch. `make branches` and, with a hundredth of the poses, `make branches-sample` run that.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from peer_bench.machine import describe

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from agrik_fast import Robot, set_num_threads, solvers
from agrik_fast.result import Warnings
from branch_arms import apart, holds, of_reference, read_off, reference, robot

Array = NDArray[np.float64]
BLOCK = 5_000
RANDOM_ARMS = 5
# Shares of poses whose posture may be missed; what is missed by chance in a sample is one more.
GENERAL = 1e-4
NEARLY_SPHERICAL = 3e-4
NEARLY = ("crx10ia", "m1013", "hc10", "cr7")
# Values of the locked joint at which arms of seven joints are held against starts.
LOCKS = 4


def random_arm(seed: int) -> Robot:
    """Return six joints with axes and points drawn from nothing in particular."""
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(6, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    points = np.cumsum(rng.normal(scale=0.4, size=(6, 3)), axis=0)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    tool = np.eye(4)
    tool[:3, :3] = turn * np.sign(np.linalg.det(turn))
    tool[:3, 3] = points[-1] + rng.normal(scale=0.3, size=3)
    return robot(axes, points, tool)


def arms() -> dict[str, Robot]:
    """Return the arms by name."""
    data = reference()
    found = {
        name: of_reference(arm) for kind in ("six", "seven") for name, arm in data[kind].items()
    }
    return found | {f"random_{k}": random_arm(100 + k) for k in range(RANDOM_ARMS)}


def cpu_us(work: Callable[[], object], count: int) -> float:
    """Return the CPU time of one of `count` things that `work` does, us."""
    started = time.process_time_ns()
    work()
    return (time.process_time_ns() - started) / count / 1e3


def least_us(work: Callable[[], object], count: int) -> float:
    """Return the least of three such times, us."""
    return min(cpu_us(work, count) for _ in range(3))


def branches_of(arm: Robot, poses: Array, q: Array) -> Any:
    """Return all branches; of seven joints those with the usual one locked where it is."""
    locked = arm.family.locked
    if locked is None:
        angle = arm.arm_angle(q) if arm.family.name == "S-R-S" else None
        return arm.ik_all(poses, arm_angle=angle)
    return arm.ik_all(poses, locked={locked: q[:, arm.joint_names.index(locked)]})


def measure(name: str, arm: Robot, count: int, starts: int) -> dict[str, Any]:
    """Return what there is to say of one arm."""
    rng = np.random.default_rng(20)
    row: dict[str, Any] = {"arm": name, "family": arm.family.name, "poses": count}
    missed = odd = false = total = second = 0
    most, worst = 0, 0.0
    histogram: dict[int, int] = {}
    for first in range(0, count, BLOCK):
        q = rng.uniform(-np.pi, np.pi, (min(BLOCK, count - first), arm.dof))
        poses = arm.fk(q)
        found = branches_of(arm, poses, q)
        missed += int((~holds(found, q)).sum())
        counts = found.reached.sum(axis=1)
        odd += int((counts % 2 != 0).sum())
        total += int(counts.sum())
        most = max(most, int(counts.max()))
        for value, times in zip(*np.unique(counts, return_counts=True), strict=True):
            histogram[int(value)] = histogram.get(int(value), 0) + int(times)
        second += int((found.warnings & Warnings.SECOND_CUT != 0).sum())
        target, branch = np.nonzero(found.reached)
        off = np.abs(arm.fk(found.q[target, branch]) - poses[target]).max(axis=(1, 2))
        false += int((off > 1e-9).sum())
        worst = max(worst, float(off.max(initial=0.0)))
    row |= {"missed": missed, "odd": odd, "false": false, "mean": total / count, "most": most}
    row |= {"second_look": second / count, "worst_fk_error": worst, "branches": histogram}
    q = rng.uniform(-np.pi, np.pi, (2_000, arm.dof))
    poses = arm.fk(q)
    branches_of(arm, poses[:64], q[:64])
    row["batch_us"] = min(cpu_us(lambda: branches_of(arm, poses, q), len(q)) for _ in range(3))
    row["single_us"] = min(_single(arm, poses, q) for _ in range(3))
    if arm.dof == 7:
        some = poses[:20]
        arm.ik_all(some[:2], sweep=64)
        row["sweep64_us"] = min(
            cpu_us(lambda: arm.ik_all(some, sweep=64), len(some)) for _ in range(3)
        )
    if starts:
        row["missed_by_starts"] = beside_starts(arm, starts, rng)
    return row


def allowed(row: dict[str, Any]) -> int:
    """Return how many postures an arm may miss."""
    if "general" not in row["family"]:
        return 0
    share = NEARLY_SPHERICAL if row["arm"] in NEARLY else GENERAL
    return int(share * row["poses"] + 1.0)


def beside_starts(arm: Robot, poses: int, rng: np.random.Generator) -> dict[str, int]:
    """Return the same as `against_starts`; of seven joints with the usual one locked."""
    locked = arm.family.locked
    if locked is None:
        return against_starts(arm, poses, rng) if arm.dof == 6 else {}
    total: dict[str, int] = {}
    for value in rng.uniform(-np.pi, np.pi, LOCKS):
        one = against_starts(arm.lock({locked: float(value)}), poses // LOCKS, rng)
        total = {key: total.get(key, 0) + count for key, count in one.items()}
    return total


def _single(arm: Robot, poses: Array, q: Array, calls: int = 300) -> float:
    locked = arm.family.locked
    if locked is None:
        return cpu_us(lambda: [arm.ik_all(pose) for pose in poses[:calls]], calls)
    at = q[:, arm.joint_names.index(locked)].tolist()
    pairs = list(zip(poses[:calls], at, strict=False))
    return cpu_us(lambda: [arm.ik_all(pose, locked={locked: x}) for pose, x in pairs], calls)


def against_starts(arm: Robot, poses: int, rng: np.random.Generator) -> dict[str, int]:
    """Return how many branches 256 starts a pose find, and how many of them are not ours."""
    numeric = solvers.LevenbergMarquardt(max_restarts=0)
    goals = arm.fk(rng.uniform(-np.pi, np.pi, (poses, 6)))
    found = arm.ik_all(goals)
    seen = lost = ours = 0
    for i, goal in enumerate(goals):
        tried = arm.ik(
            np.broadcast_to(goal, (256, 4, 4)),
            q0=rng.uniform(-np.pi, np.pi, (256, 6)),
            solver=numeric,
            position_tolerance=1e-10,
            orientation_tolerance=1e-10,
        )
        mine = found.q[i][found.reached[i]]
        distinct: list[Array] = []
        for q in tried.q[tried.success]:
            if all(apart(q, other).max() > 1e-4 for other in distinct):
                distinct.append(q)
        seen += len(distinct)
        ours += len(mine)
        lost += sum(apart(q, mine).max(axis=1).min(initial=9.0) > 1e-3 for q in distinct)
    return {"poses": poses, "ours": ours, "of_starts": seen, "lost": int(lost)}


def peers(count: int) -> list[dict[str, Any]]:
    """Return times and sets of others beside ours, of those that are installed."""
    return eaik(count) + ssik(count // 10)


def eaik(count: int) -> list[dict[str, Any]]:
    """Return the same of EAIK."""
    try:
        from eaik.IK_HP import HPRobot
    except ImportError:
        return []
    six = reference()["six"]
    names = ("puma560", "ur5", "ur5e", "z1")
    return [_beside_eaik(name, six[name], HPRobot, count) for name in names]


def _beside_eaik(name: str, given: dict[str, Any], maker: Any, count: int) -> dict[str, Any]:
    arm, tool = of_reference(given), np.array(given["tool"])
    ways = np.diff(np.vstack([np.zeros(3), np.array(given["points"]), tool[:3, 3]]), axis=0)
    peer = maker(np.array(given["axes"]), ways)
    q = np.random.default_rng(21).uniform(-np.pi, np.pi, (count, 6))
    poses = arm.fk(q)
    # The peer's tool frame has no home rotation.
    seen = poses.copy()
    seen[:, :3, :3] = poses[:, :3, :3] @ tool[:3, :3].T
    ours = arm.ik_all(poses)
    same = 0
    for i, pose in enumerate(seen):
        their = peer.IK(pose)
        exact = np.asarray(their.Q)[~np.asarray(their.is_LS, bool)]
        mine = ours.q[i][ours.reached[i]]
        if len(exact) and len(mine):
            far = apart(exact[:, None], mine[None]).max(axis=2)
            same += bool(far.min(axis=0).max() < 1e-5 and far.min(axis=1).max() < 1e-5)
    return {
        "arm": name,
        "same_sets": f"{same}/{count}",
        "eaik_single_us": least_us(lambda: [peer.IK(pose) for pose in seen], count),
        "eaik_batch_us": least_us(lambda: peer.IK_batched(list(seen), 1), count),
        "single_us": least_us(lambda: [arm.ik_all(pose) for pose in poses], count),
        "batch_us": least_us(lambda: arm.ik_all(poses), count),
    }


# Arms for which ssik brings what it prepared.
SSIK = ("jaco2", "xarm6", "piper", "gen3_lite", "fanuc_crx10ia", "m1013", "hc10", "xmatecr7")


def ssik(count: int) -> list[dict[str, Any]]:
    """Return the same of ssik, as it comes (to 1e-5) and with its refinement."""
    try:
        from ssik import Manipulator
    except ImportError:
        return []
    return [_beside_ssik(name, Manipulator.from_prebuilt(f"{name}_ik"), count) for name in SSIK]


def _beside_ssik(name: str, peer: Any, count: int) -> dict[str, Any]:
    arm = read_off(peer.fk)
    poses = arm.fk(np.random.default_rng(22).uniform(-np.pi, np.pi, (max(count, 1), 6)))

    def their(*, refined: bool) -> list[Any]:
        wishes = {"respect_limits": False, "enumerate_windings": False}
        return [peer.solve(pose, allow_refinement=refined, **wishes) for pose in poses]

    many = np.repeat(poses, -(-1_000 // len(poses)), axis=0)
    ours, batch = arm.ik_all(poses), least_us(lambda: arm.ik_all(many), len(many))
    rough = least_us(lambda: their(refined=False), len(poses))
    counts = [len(found) for found in their(refined=True)]
    return {
        "arm": name,
        "same_counts": f"{int((ours.reached.sum(axis=1) == counts).sum())}/{len(poses)}",
        "ssik_us": rough,
        "ssik_refined_us": least_us(lambda: their(refined=True), len(poses)),
        "single_us": least_us(lambda: [arm.ik_all(pose) for pose in poses], len(poses)),
        "batch_us": batch,
        "ratio": rough / batch,
    }


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--poses", type=int, default=2_000)
    parser.add_argument("--starts", type=int, default=0, help="poses that get 256 starts each")
    parser.add_argument("--arms", default="", help="names, with commas; default all")
    parser.add_argument("--peers", type=int, default=1_000, help="poses of the peers; 0 for none")
    parser.add_argument("--check", action="store_true", help="fail where too much is missed")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    set_num_threads(1)
    rows = []
    for name, arm in arms().items():
        if options.arms and name not in options.arms.split(","):
            continue
        row = measure(name, arm, options.poses, options.starts)
        rows.append(row)
        sweep = f" sweep64 {row['sweep64_us']:7.0f} us" if "sweep64_us" in row else ""
        starts = f" starts {row['missed_by_starts']}" if "missed_by_starts" in row else ""
        print(
            f"{name:10} {row['family'][:34]:34} missed {row['missed']} odd {row['odd']} "
            f"false {row['false']} mean {row['mean']:.2f} most {row['most']} "
            f"batch {row['batch_us']:6.2f} us single {row['single_us']:6.1f} us{sweep}{starts}",
            flush=True,
        )
    beside = peers(options.peers) if options.peers else []
    for row in beside:
        print({key: round(x, 2) if isinstance(x, float) else x for key, x in row.items()})
    if options.json:
        text = json.dumps({"machine": describe(), "arms": rows, "peers": beside}, indent=1)
        options.json.write_text(text)
    if options.check:
        bad = [row for row in rows if row["false"] or row["missed"] > allowed(row)]
        for row in bad:
            print(f"{row['arm']}: {row['missed']} missed (of {row['poses']}), {row['false']} false")
        sys.exit(1 if bad or not rows else 0)


if __name__ == "__main__":
    main()
