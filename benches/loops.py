"""Control loops, paths, nearest answers and second aims against what they have to show.

    python benches/loops.py [--quick] [--only ticks,lines,starts,nearest,aims,limits,time,peers]
    python benches/loops.py --only lines --packages .venv-robots

One core, one thread. With --packages lines are followed on arms of URDFs too (`make robustness`
installs them). pink and mink (PyPI: pin-pink, mink, quadprog) follow the same loop of the same
arm where they are installed, and are said to be missing where not. Exit status 1 where a bound is
missed.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import tempfile
import time
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from robust.files import ROBOTS

import agrik_fast as ik

MOST = 0.02
MISSES: list[str] = []


def show(what: str, value: float, bound: str, ok: bool) -> None:
    print(f"| {what} | {value:.6g} | {bound} | {'yes' if ok else 'NO'} |", flush=True)
    if not ok:
        MISSES.append(what)


def drawn(arm: ik.Robot) -> tuple[np.ndarray, np.ndarray]:
    """Limits, and a turn for joints without."""
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    return lower, np.where(np.isfinite(arm.upper), arm.upper, np.pi)


def pieces(arm: ik.Robot, rng: np.random.Generator) -> Any:
    """Yield pieces of a random drive: poses, and which of them are on a path in joint space."""
    lower, upper = drawn(arm)
    q = rng.uniform(lower, upper)
    yield q, arm.fk(q)[None], np.ones(1, dtype=bool)
    while True:
        to = rng.uniform(lower, upper)
        steps = int(np.ceil((abs(to - q) / (0.4 * MOST)).max()))
        path = q + np.linspace(0, 1, steps + 1)[1:, None] * (to - q)
        poses, inside = arm.fk(path), np.ones(steps, dtype=bool)
        if rng.random() < 0.5 and steps > 4:
            first, last = np.sort(rng.integers(0, steps, 2))
            way = rng.normal(size=3)
            way *= 3 * arm.reach_radius / np.linalg.norm(way)
            share = np.sin(np.linspace(0, np.pi, last - first + 1)) ** 2
            poses[first : last + 1, :3, 3] += share[:, None] * way
            inside[first : last + 1] = False
        yield to, poses, inside
        q = to


def in_reach(arm: ik.Robot, q: np.ndarray, poses: list[np.ndarray]) -> bool:
    """Say whether any posture of any of these ticks was near enough to get there in time.

    The loop has no part in it: after k ticks an arm can stand anywhere within k bounds of where
    it stood, and nowhere else. All branches (of arms with seven joints at 128 values of the free
    quantity) and 16 starts within these bounds say whether a posture is there. The judge knows
    where the target will go, which a loop does not.
    """
    for k in range(len(poses), 0, -1):
        low, high = np.maximum(q - k * MOST, arm.lower), np.minimum(q + k * MOST, arm.upper)
        pose = poses[k - 1]
        if arm.dof >= 6 and arm.family.branches > 0:
            sweep = 128 if arm.dof == 7 else None
            every = arm.ik_all(pose, q0=q, sweep=sweep, wrap=sweep is None)
            inside = ((every.q >= low) & (every.q <= high)).all(-1)
            if (inside & every.valid).any():
                return True
        box = arm.with_limits(np.stack([low, high], axis=1))
        starts = np.random.default_rng(k).uniform(low, high, (16, arm.dof))
        if box.ik(np.broadcast_to(pose, (16, 4, 4)), q0=starts).success.any():
            return True
    return False


def ticks(name: str, count: int) -> None:
    """Drive an arm at random; print its largest change and how soon it is back.

    Where a target comes back into the reach it waits for the arm in every second case, and goes
    on in the others: with up to 0.4 of what joints may do, on a path that is another posture's.
    Of those that are late it says how many could have been in time.
    """
    arm = ik.Robot.load(name)
    rng = np.random.default_rng(7)
    loop = arm.solver(max_change=MOST)
    drive = pieces(arm, rng)
    q, _, _ = next(drive)
    loop.solve(arm.fk(q), q)
    q, largest, done, before = loop.q, 0.0, 0, True
    entries, late = [0, 0], [0, 0]
    lost: list[tuple[np.ndarray, list[np.ndarray]]] = []

    def tick(pose: np.ndarray) -> bool:
        nonlocal q, largest, done
        reached = loop.solve(pose)
        largest, q, done = max(largest, abs(loop.q - q).max()), loop.q, done + 1
        return reached

    left: float | None = None
    since: list[np.ndarray] = []
    stood = q
    while done < count:
        _, poses, inside = next(drive)
        for pose, reach in zip(poses, inside.tolist(), strict=True):
            if not reach:
                left = None
            elif not before:
                there = arm.ik(pose, q0=q, nearest=True)
                left = 2 * (abs(there.q - q) / MOST).max() + 10
                waits = rng.random() < 0.5
                entries[waits] += 1
                while waits and left >= 0 and not tick(pose):
                    left -= 1
                if waits:
                    late[True] += left < 0
                    left = None
                stood, since = q, []
            before, reached = reach, tick(pose)
            if left is not None:
                left -= 1
                since.append(pose)
                if reached or left < 0:
                    if not reached:
                        late[False] += 1
                        lost.append((stood, since))
                    left = None
    show(f"{name}: largest change, {done} ticks", largest, f"<= {MOST}", largest <= MOST)
    for waits, what in ((True, "waits"), (False, "goes on")):
        share = 1 - late[waits] / max(entries[waits], 1)
        title = f"{name}: back in time, target {what}, of {entries[waits]}"
        show(title, share, ">= 0.999", share >= 0.999)
    avoidable = sum(in_reach(arm, *one) for one in lost)
    title = f"{name}: of {len(lost)} late ones could have been in time"
    show(title, avoidable, f"<= {entries[False] / 1000:.3g}", avoidable <= entries[False] / 1000)


def lines(count: int, packages: Path | None) -> None:
    """Follow lines in joint space of all arms."""
    arms = {name: ik.Robot.load(name) for name in ik.Robot.names()}
    if packages is not None:
        for name, urdf in ROBOTS.items():
            file = urdf.path(packages)
            arms[name] = ik.Robot.from_urdf(file, base_link=urdf.base, tip_link=urdf.tip)
    all_broken = all_steps = 0
    for name, arm in arms.items():
        rng = np.random.default_rng(5)
        broken = steps = 0
        for _ in range(count):
            begin, end = rng.uniform(*drawn(arm), (2, arm.dof))
            path = begin + np.linspace(0, 1, 201)[1:, None] * (end - begin)
            most = np.maximum(0.1, 1.5 * abs(end - begin) / 200)
            broken += int(arm.follow(arm.fk(path), begin, most).discontinuity.sum())
            steps += 200
        if broken:
            print(f"| {name}: discontinuities | {broken} of {steps} | | |", flush=True)
        all_broken, all_steps = all_broken + broken, all_steps + steps
    what = f"{len(arms)} arms: discontinuities of {all_steps} steps on lines in joint space"
    show(what, all_broken, "0", all_broken == 0)


def starts(count: int) -> None:
    """Follow Cartesian lines without a start, and from twelve others where that breaks."""
    for name in ik.Robot.names():
        arm = ik.Robot.load(name)
        broken = avoidable = 0
        for seed in range(count):
            begin, end = arm.fk(arm.random_q(2, seed=seed))
            targets = np.tile(begin, (200, 1, 1))
            way = end[:3, 3] - begin[:3, 3]
            targets[:, :3, 3] += np.linspace(0, 0.5, 200)[:, None] * way
            if arm.dof < 6:
                targets = targets[:, :3, 3]
            if not arm.follow(targets, max_joint_step=0.2).discontinuity.any():
                continue
            broken += 1
            for start in range(12):
                first = arm.ik(targets[0], seed=start + 50)
                other = arm.follow(targets, first.q, max_joint_step=0.2)
                if first.success and not other.discontinuity.any():
                    avoidable += 1
                    break
        show(f"{name}: avoidable breaks, {broken} of {count}", avoidable, "0", avoidable == 0)


def nearest(count: int) -> None:
    """Set nearest answers beside all branches, or many starts."""
    for name in ik.Robot.names():
        arm = ik.Robot.load(name)
        task = "pose" if arm.dof >= 6 else "position"
        known = arm.dof == 6 and arm.family.branches > 0
        rows = count if known else count // 10
        q = arm.random_q(rows, seed=4)
        rng = np.random.default_rng(1)
        q0 = np.clip(q + rng.uniform(-0.3, 0.3, q.shape), arm.lower, arm.upper)
        poses = arm.fk(q)
        goals = poses if task == "pose" else poses[:, :3, 3]
        mine = np.linalg.norm(arm.ik(goals, q0=q0, nearest=True).q - q0, axis=1)
        if known:
            every = arm.ik_all(poses, q0=q0, wrap=True)
            away = np.linalg.norm(every.q - q0[:, None], axis=2)
            least = np.where(every.valid, away, np.inf).min(1)
        else:
            # A number asks for starts, whatever the arm: a sweep is not its own judge.
            least = np.linalg.norm(arm.ik(goals, q0=q0, nearest=256).q - q0, axis=1)
        share, bound = float((mine <= least + 1e-5).mean()), 0.999 if known else 0.99
        show(f"{name}: nearest of {rows}", share, f">= {bound}", share >= bound)


def measured(arm: ik.Robot, aim: str, q: np.ndarray) -> np.ndarray:
    """Return what a second aim makes of postures; the less the better."""
    middle, half = (arm.lower + arm.upper) / 2, (arm.upper - arm.lower) / 2
    if aim == "near":
        return 0.5 * ((q - middle) ** 2).sum(1)
    if aim == "middle":
        return 0.5 * (((q - middle) / half) ** 2).sum(1)
    if aim == "limits":
        with np.errstate(divide="ignore"):
            return (half**2 / ((arm.upper - q) * (q - arm.lower))).sum(1)
    jacobian = arm.jacobian(q)
    return -0.5 * np.linalg.slogdet(jacobian @ np.swapaxes(jacobian, 1, 2))[1]


def betterable(arm: ik.Robot, aim: str, count: int) -> int:
    """Count answers that 0.01 rad along the arm's own freedom, to a side, are better by 1e-3."""
    goals = arm.fk(arm.random_q(count, seed=8))
    found = arm.ik(goals, second_aim=aim)
    before, better = measured(arm, aim, found.q), np.zeros(count, dtype=bool)
    along = np.linalg.svd(arm.jacobian(found.q))[2][:, -1]
    for side in (0.01, -0.01):
        q = found.q + side * along
        for _ in range(5):
            now = arm.fk(q)
            turn = np.cross(now[:, :3, :3], goals[:, :3, :3], axis=1).sum(2) / 2
            error = np.concatenate([goals[:, :3, 3] - now[:, :3, 3], turn], axis=1)
            q = q + np.einsum("nij,nj->ni", np.linalg.pinv(arm.jacobian(q)), error)
        inside = ((q >= arm.lower) & (q <= arm.upper)).all(1) & (abs(error).max(1) < 1e-5)
        q = np.where(inside[:, None], q, found.q)
        better |= measured(arm, aim, q) < before - 1e-3
    return int((better & found.success).sum())


def aims(count: int) -> None:
    """Time second aims beside none, and count ends where something near is better."""
    for name in ("redundant7", "panda", "iiwa14"):
        arm = ik.Robot.load(name)
        poses = arm.fk(arm.random_q(count, seed=3))
        seconds = dict.fromkeys((None, "near", "middle", "limits", "manipulability"), np.inf)
        success = {}
        for _ in range(7):
            for aim in seconds:
                start = time.process_time()
                result = arm.ik(poses, threads=1, second_aim=aim)
                seconds[aim] = min(seconds[aim], time.process_time() - start)
                success[aim] = result.success
        for aim in list(seconds)[1:]:
            same = bool((success[aim] == success[None]).all())
            show(f"{name}, {aim}: success as without", float(same), "1", same)
            ratio = seconds[aim] / seconds[None]
            show(f"{name}, {aim}: time", ratio, "<= 2", ratio <= 2)
            few = min(count, 3_000)
            better = betterable(arm, aim, few)
            show(f"{name}, {aim}: better near by, of {few}", better, "<= 1 %", better <= few / 100)


def limits(count: int) -> None:
    """Count answers exactly at a limit, and time limits of each row beside those of a call."""
    for name in ("ur5", "panda"):
        arm = ik.Robot.load(name)
        lower, upper = drawn(arm)
        q = arm.random_q(count, seed=9)
        poses = arm.fk(q)
        each = np.stack([np.maximum(lower, q - 1.5), np.minimum(upper, q + 1.5)], axis=-1)
        seconds = []
        for given in (np.stack([lower, upper], axis=-1), each):
            best = np.inf
            for _ in range(5):
                start = time.process_time()
                arm.ik(poses, threads=1, limits=given)
                best = min(best, time.process_time() - start)
            seconds.append(best)
        ratio = seconds[1] / seconds[0]
        show(f"{name}: limits of each row, time of those of a call", ratio, "<= 5", ratio <= 5)
    for name in ("redundant7", "panda", "iiwa14", "fr3", "gen3", "xarm7"):
        arm = ik.Robot.load(name)
        result = arm.ik(arm.fk(arm.random_q(count, seed=9)))
        at = ((result.q <= arm.lower) | (result.q >= arm.upper)).any(1)
        share = float(at[result.success].mean())
        show(f"{name}: at a limit, of {count}", share, "<= 0.01", share <= 0.01)


def warm(_: int) -> None:
    """Time usual ticks."""
    for name in ("ur5", "panda"):
        arm = ik.Robot.load(name)
        # Away from limits: beyond one there is no such path.
        q = np.clip(arm.home + 0.3, arm.lower + 0.1, arm.upper - 0.1)
        path = [arm.fk(q + 5e-4 * np.sin(k / 30)) for k in range(200)]
        for what, most in (("warm call", None), ("tick", 0.05)):
            loop = arm.solver(max_change=most)
            loop.solve(path[0], q)
            solve, q0 = loop.solve, loop.q
            best = np.inf
            for _ in range(200):
                start = time.perf_counter()
                for pose in path:
                    solve(pose, q0)
                best = min(best, (time.perf_counter() - start) / len(path))
            show(f"{name}: {what}, us", best * 1e6, "<= 2", best <= 2e-6)


def as_urdf(arm: ik.Robot) -> str:
    """Write an arm of revolute joints as a URDF, its frames turned as the base is at zero."""
    zero = np.zeros(arm.dof)
    tool, jacobian = arm.fk(zero), arm.jacobian(zero)
    axes = jacobian[3:].T
    places = tool[:3, 3] - np.cross(jacobian[:3].T, axes)
    inertia = '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>'
    solid = f'<inertial><mass value="1"/>{inertia}</inertial>'
    text = '<robot name="arm"><mujoco><compiler fusestatic="false"/></mujoco><link name="base"/>'
    before, parent = np.zeros(3), "base"
    for k, (place, axis, low, high) in enumerate(
        zip(places, axes, arm.lower, arm.upper, strict=True)
    ):
        way, along = (" ".join(map(repr, map(float, v))) for v in (place - before, axis))
        text += f'<link name="link{k}">{solid}</link><joint name="joint{k}" type="revolute">'
        text += f'<parent link="{parent}"/><child link="link{k}"/><origin xyz="{way}"/>'
        text += (
            f'<axis xyz="{along}"/><limit lower="{low}" upper="{high}" effort="1" velocity="9"/>'
        )
        text += "</joint>"
        before, parent = place, f"link{k}"
    turn, m = np.zeros(3), tool[:3, :3]
    turn[:] = (
        np.arctan2(m[2, 1], m[2, 2]),
        np.arctan2(-m[2, 0], np.hypot(m[2, 1], m[2, 2])),
        np.arctan2(m[1, 0], m[0, 0]),
    )
    way, rpy = (" ".join(map(repr, map(float, v))) for v in (tool[:3, 3] - before, turn))
    text += f'<link name="tool">{solid}</link><joint name="fixed" type="fixed">'
    text += (
        f'<parent link="{parent}"/><child link="tool"/><origin xyz="{way}" rpy="{rpy}"/></joint>'
    )
    return text + "</robot>"


def peers(count: int) -> None:
    """Let pink and mink follow the same target, and say how near they stay."""
    arm = ik.Robot.load("ur5")
    begin = np.array([0.3, -1.2, 1.4, -0.6, 1.2, 0.2])
    turn = 0.5 * np.sin(np.linspace(0, 2 * np.pi * count / 1000, count))
    path = begin + turn[:, None] * np.array([1.0, 0.3, -0.2, 0.1, 0.1, 0.5])

    def ours() -> tuple[float, float]:
        poses = arm.fk(path)
        loop = arm.solver(max_change=MOST)
        loop.solve(poses[0], begin)
        start, worst = time.process_time(), 0.0
        for pose in poses:
            loop.solve(pose)
            worst = max(worst, loop.position_error)
        return (time.process_time() - start) / count, worst

    def pink() -> tuple[float, float]:
        import pinocchio as pin
        from pink import Configuration, solve_ik
        from pink.tasks import FrameTask

        model = pin.buildModelFromXML(as_urdf(arm))
        state = Configuration(model, model.createData(), path[0].copy())
        task = FrameTask("tool", position_cost=1.0, orientation_cost=1.0, lm_damping=1e-6)
        targets = [pin.SE3(pose) for pose in arm.fk(path)]
        start, worst = time.process_time(), 0.0
        for target in targets:
            task.set_target(target)
            state.integrate_inplace(solve_ik(state, [task], 1e-3, solver="quadprog"), 1e-3)
            there = state.get_transform_frame_to_world("tool")
            worst = max(worst, float(np.linalg.norm(there.translation - target.translation)))
        return (time.process_time() - start) / count, worst

    def mink() -> tuple[float, float]:
        import mink as library
        import mujoco

        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "arm.urdf"
            file.write_text(as_urdf(arm), encoding="utf-8")
            model = mujoco.MjModel.from_xml_path(str(file))
        state = library.Configuration(model, q=path[0].copy())
        task = library.FrameTask("tool", "body", position_cost=1.0, orientation_cost=1.0)
        targets = [library.SE3.from_matrix(pose) for pose in arm.fk(path)]
        state.update(path[0].copy())
        start, worst = time.process_time(), 0.0
        for target in targets:
            task.set_target(target)
            rates = library.solve_ik(state, [task], 1e-3, solver="quadprog")
            state.integrate_inplace(rates, 1e-3)
            there = state.get_transform_frame_to_world("tool", "body")
            off = there.translation() - target.translation()
            worst = max(worst, float(np.linalg.norm(off)))
        return (time.process_time() - start) / count, worst

    seconds, error = ours()
    print(f"| ours: us a tick, worst error m | {seconds * 1e6:.3g}, {error:.3g} | | |")
    for name, module, run in (("pink", "pink", pink), ("mink", "mink", mink)):
        if importlib.util.find_spec(module) is None:
            print(f"| {name} | not installed | | |")
            continue
        try:
            theirs, off = run()
        except Exception as error_of_peer:  # a peer's own trouble is told, not ours
            print(f"| {name} | {type(error_of_peer).__name__}: {error_of_peer} | | |")
            continue
        print(f"| {name}: us a tick, worst error m | {theirs * 1e6:.3g}, {off:.3g} | | |")
        print(f"| {name}: times as long | {theirs / seconds:.3g} | | |")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default="ticks,lines,starts,nearest,aims,limits,time,peers")
    parser.add_argument("--packages", type=Path, help="where the packages with URDFs are")
    chosen = parser.parse_args()
    quick = chosen.quick
    ik.set_num_threads(1)
    print("| measure | value | bound | met |\n|---|---|---|---|")
    for part in chosen.only.split(","):
        match part:
            case "ticks":
                for name in ik.Robot.names():
                    ticks(name, 5_000 if quick else 1_000_000)
            case "lines":
                lines(3 if quick else 27, chosen.packages)
            case "starts":
                starts(10 if quick else 60)
            case "nearest":
                nearest(500 if quick else 10_000)
            case "aims":
                aims(3_000 if quick else 50_000)
            case "limits":
                limits(3_000 if quick else 100_000)
            case "time":
                warm(0)
            case "peers":
                peers(1_000 if quick else 10_000)
            case _:
                parser.error(f"unknown part {part!r}")
    print(f"\nmissed: {', '.join(MISSES) or 'none'}")
    return bool(MISSES)


if __name__ == "__main__":
    raise SystemExit(main())
