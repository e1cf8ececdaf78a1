"""Large samples of what proofs stand on; run as a program.

    PYTHONPATH=tests python tests/proofs_full.py [--moves 1000000] [--samples 100000]

Levers: no point of a body moves farther than its levers say, with positions by a forward
kinematics of its own. Segments: what is called free keeps what is certified at all samples of a
judge that shares nothing with the library, what is called a hit has a posture that hits, and the
way back has the same answer.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator

import numpy as np

import numpy_collision
import path_checker
import spec_scenes
from agrik_fast import Robot, motion
from agrik_fast.collision import Scene

ARMS = ("cucumber", "panda", "redundant7", "ur10e")
SCENES = {"cucumber": ("scene", "greenhouse1", "greenhouse2"), "panda": ("bench", "wall")}
CLEAR = 0.002
MOVES = 20
"""Displacements round one posture."""


def displacements(name: str, count: int, seed: int = 0) -> tuple[int, int, float]:
    """Return how many displacements there were, how many too far, and the largest share."""
    arm, rng = Robot.load(name), np.random.default_rng(seed)
    bodies = arm.compiled_bodies()
    moving = [k for k, frame in enumerate(bodies.frames) if frame > 0]
    names = [bodies.names[k] for k in moving]
    done = wrong = 0
    largest = 0.0
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    while done < count:
        middle = rng.uniform(lower, upper)
        most = rng.uniform(0, 1, arm.dof) * 10.0 ** rng.uniform(-3, 0.3)
        change = rng.uniform(-1, 1, (MOVES, arm.dof)) * most
        # Now and then as far as is allowed.
        change[: MOVES // 4] = np.sign(change[: MOVES // 4]) * most
        bound = np.abs(change) @ bodies.levers(middle, most)[:, moving]
        solids = numpy_collision.solids_of_arm(
            name, np.concatenate([middle[None], middle + change])
        )
        for k, body in enumerate(names):
            ends = [end for edge in solids[body][1].edges() for end in edge]
            moved = np.max([np.linalg.norm(end[1:] - end[0], axis=1) for end in ends], axis=0)
            wrong += int((moved > bound[:, k] + 1e-9).sum())
            largest = max(largest, float((moved / np.maximum(bound[:, k], 1e-12)).max()))
            done += MOVES
    return done, wrong, largest


def ways(name: str, scene: Scene, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return ends of ways of all lengths, half of them from free postures."""
    arm, rng = Robot.load(name), np.random.default_rng(seed)
    a = arm.random_q(3 * count, seed=seed)
    free = a[~scene.collides(arm, a, clear=CLEAR)][: count // 2]
    a = np.concatenate([free, a[: count - len(free)]])
    b = a + 10.0 ** rng.uniform(-2, 0, (len(a), 1)) * (arm.random_q(len(a), seed=seed + 1) - a)
    return a, b


def judged(name: str, samples: int, seed: int = 0) -> Iterator[tuple[str, int, str | None]]:
    """Yield the outcome of ways, at how many samples it was judged, and what is wrong."""
    arm = Robot.load(name)
    scenes = spec_scenes.scenes(name)
    done = 0
    while done < samples:
        seed += 1
        scene = scenes[SCENES[name][seed % len(SCENES[name])]]
        a, b = ways(name, scene, 40, seed)
        back = motion.check_segments(arm, b, a, scene, clear=CLEAR, cap=0.01)
        there = motion.check_segments(arm, a, b, scene, clear=CLEAR, cap=0.01)
        for k, outcome in enumerate(there.outcome):
            fault, count = None, 1
            if outcome != back.outcome[k]:
                fault = f"{motion.Outcome(back.outcome[k]).name} on the way back"
            path = np.stack([a[k], b[k]])
            if outcome == motion.Outcome.SAFE:
                certified = float(there.clearance[k])
                found = path_checker.judge(
                    name, path, scene, arm.self_pairs.asked, near=certified + 1e-4
                )
                count = found.samples
                if found.least < certified - 1e-9:
                    fault = f"{found.least} m where {certified} m are certified"
            elif outcome == motion.Outcome.HIT:
                witness = motion.check(arm, path, scene, clear=CLEAR).witness
                met = path_checker.judge(
                    name, witness[None], scene, arm.self_pairs.asked, near=CLEAR + 1e-6
                )
                least = met.least
                if least > CLEAR + 1e-9:
                    fault = f"a hit at {least} m"
            done += count
            said = None if fault is None else f"{name}, ways of seed {seed}, {k}: {fault}"
            yield motion.Outcome(outcome).name, count, said


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--moves", type=int, default=1_000_000)
    parser.add_argument("--samples", type=int, default=100_000)
    given = parser.parse_args()
    faults = []
    for name in ARMS:
        done, wrong, largest = displacements(name, given.moves // len(ARMS))
        print(
            f"levers of {name}: {done} displacements, {wrong} too far, at most {largest:.3f} of it"
        )
        faults += [f"levers of {name}"] * (wrong > 0)
    for name in SCENES:
        outcomes: Counter[str] = Counter()
        samples = 0
        for outcome, count, fault in judged(name, given.samples // len(SCENES)):
            outcomes[outcome] += 1
            samples += count
            faults += [] if fault is None else [fault]
        print(f"ways of {name}: {dict(outcomes)}, {samples} samples")
    for said in faults:
        print(said)
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
