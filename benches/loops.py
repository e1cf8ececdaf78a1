"""Control loops, paths, nearest answers and second aims against what they have to show.

    python benches/loops.py [--quick] [--only ticks,lines,starts,nearest,aims,limits,time,peers]

One core, one thread. pink and mink (PyPI: pin-pink, mink, robot_descriptions, quadprog) follow
the same loop where they are installed, and are said to be missing where not. Exit status 1
where a bound is missed.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import time
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

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


def ticks(name: str, count: int) -> None:
    """Drive an arm at random; print its largest change and how soon it is back."""
    arm = ik.Robot.load(name)
    rng = np.random.default_rng(7)
    loop = arm.solver(max_change=MOST)
    drive = pieces(arm, rng)
    q, _, _ = next(drive)
    largest, entries, late, done, waiting = 0.0, 0, 0, 0, None
    before = True
    first = True
    while done < count:
        _, poses, inside = next(drive)
        for pose, reach in zip(poses, inside.tolist(), strict=True):
            if reach and not before:
                there = arm.ik(pose, q0=q, nearest=True)
                entries += 1
                waiting = [0, 2 * (abs(there.q - q) / MOST).max() + 10]
            if not reach:
                waiting = None
            reached = loop.solve(pose, q if first else None)
            first = False
            new = loop.q
            largest, q, before = max(largest, abs(new - q).max()), new, reach
            if waiting is not None:
                waiting[0] += 1
                if reached:
                    waiting = None
                elif waiting[0] > waiting[1]:
                    late, waiting = late + 1, None
            done += 1
    show(f"{name}: largest change, {done} ticks", largest, f"<= {MOST}", largest <= MOST)
    share = 1 - late / max(entries, 1)
    show(f"{name}: back in time, of {entries}", share, ">= 0.999", share >= 0.999)


def lines(count: int) -> None:
    """Follow lines in joint space of all arms."""
    broken = steps = 0
    for name in ik.Robot.names():
        arm = ik.Robot.load(name)
        rng = np.random.default_rng(5)
        for _ in range(count):
            begin, end = rng.uniform(*drawn(arm), (2, arm.dof))
            path = begin + np.linspace(0, 1, 201)[1:, None] * (end - begin)
            most = np.maximum(0.1, 1.5 * abs(end - begin) / 200)
            broken += int(arm.follow(arm.fk(path), begin, most).discontinuity.sum())
            steps += 200
    show(f"discontinuities of {steps} steps on lines in joint space", broken, "0", broken == 0)


def starts(count: int) -> None:
    """Follow Cartesian lines without a start, and from twelve others where that breaks."""
    for name in ("ur5", "puma560", "hydrolek"):
        arm = ik.Robot.load(name)
        broken = avoidable = 0
        for seed in range(count):
            begin, end = arm.fk(arm.random_q(2, seed=seed))
            poses = np.tile(begin, (200, 1, 1))
            way = end[:3, 3] - begin[:3, 3]
            poses[:, :3, 3] += np.linspace(0, 0.5, 200)[:, None] * way
            if not arm.follow(poses, max_joint_step=0.2).discontinuity.any():
                continue
            broken += 1
            for start in range(12):
                first = arm.ik(poses[0], seed=start + 50)
                other = arm.follow(poses, first.q, max_joint_step=0.2)
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
            least = np.linalg.norm(arm.ik(goals, q0=q0, nearest=256).q - q0, axis=1)
        share, bound = float((mine <= least + 1e-5).mean()), 0.999 if known else 0.99
        show(f"{name}: nearest of {rows}", share, f">= {bound}", share >= bound)


def aims(count: int) -> None:
    """Time second aims beside none."""
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


def limits(count: int) -> None:
    """Count answers exactly at a limit."""
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
        q = 0.5 * (arm.home + np.clip(arm.home + 0.6, arm.lower, arm.upper))
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
        start, worst = time.perf_counter(), 0.0
        for pose in poses:
            loop.solve(pose)
            worst = max(worst, loop.position_error)
        return (time.perf_counter() - start) / count, worst

    def pink() -> tuple[float, float]:
        import pinocchio as pin
        from pink import Configuration, solve_ik
        from pink.tasks import FrameTask
        from robot_descriptions.loaders.pinocchio import load_robot_description

        robot = load_robot_description("ur5_description")
        names = [robot.model.names[k] for k in range(1, robot.model.njoints)]
        frame = "tool0" if robot.model.existFrame("tool0") else "ee_link"
        state = Configuration(robot.model, robot.data, path[0][: len(names)].copy())
        task = FrameTask(frame, position_cost=1.0, orientation_cost=1.0, lm_damping=1e-6)
        targets = []
        for q in path:
            pin.forwardKinematics(robot.model, robot.data, q)
            pin.updateFramePlacements(robot.model, robot.data)
            targets.append(robot.data.oMf[robot.model.getFrameId(frame)].copy())
        start, worst = time.perf_counter(), 0.0
        for target in targets:
            task.set_target(target)
            state.integrate_inplace(solve_ik(state, [task], 1e-3, solver="quadprog"), 1e-3)
            there = state.get_transform_frame_to_world(frame)
            worst = max(worst, float(np.linalg.norm(there.translation - target.translation)))
        return (time.perf_counter() - start) / count, worst

    def mink() -> tuple[float, float]:
        import mink as library
        from robot_descriptions.loaders.mujoco import load_robot_description

        model = load_robot_description("ur5e_mj_description")
        state = library.Configuration(model, q=path[0].copy())
        site = model.site(0).name
        task = library.FrameTask(site, "site", position_cost=1.0, orientation_cost=1.0)
        targets = []
        for q in path:
            state.update(q)
            targets.append(state.get_transform_frame_to_world(site, "site"))
        state.update(path[0].copy())
        start, worst = time.perf_counter(), 0.0
        for target in targets:
            task.set_target(target)
            rates = library.solve_ik(state, [task], 1e-3, solver="quadprog")
            state.integrate_inplace(rates, 1e-3)
            there = state.get_transform_frame_to_world(site, "site")
            off = there.translation() - target.translation()
            worst = max(worst, float(np.linalg.norm(off)))
        return (time.perf_counter() - start) / count, worst

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


BUNDLED = ("strawberry", "cucumber", "hydrolek", "tomato", "redundant7", "puma560", "ur5", "panda")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default="ticks,lines,starts,nearest,aims,limits,time,peers")
    chosen = parser.parse_args()
    quick = chosen.quick
    ik.set_num_threads(1)
    print("| measure | value | bound | met |\n|---|---|---|---|")
    for part in chosen.only.split(","):
        match part:
            case "ticks":
                for name in BUNDLED:
                    ticks(name, 5_000 if quick else 1_000_000)
            case "lines":
                lines(3 if quick else 27)
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
