"""The tomato loop before many fruits: still, moving, trembling, hidden, wild, the cable cut."""

import argparse
import sys

import numpy as np

from agrik_fast.drivers import LinkError
from pointing import NOISE, RADIUS, Seen, fruits, hidden_for_ten, pointing

CABLE = "cable"
# What is allowed, m, after 1.5 s.
LIMITS = {"still": 0.003, "trembling": 0.008, "moving": 0.010, "hidden": 0.003, "wild": 0.003}
CASES = (*LIMITS, CABLE)
# No command may jump farther, m.
LARGEST_JUMP = 0.015


def run(case: str, centre: np.ndarray, seed: int) -> Seen:
    """Return what one fruit's two seconds were like."""
    way = np.array([0.0, -0.03 * np.sign(centre[1]), 0.0]) if case == "moving" else np.zeros(3)
    with pointing(
        lambda time: centre + time * way,
        NOISE if case == "trembling" else None,
        leaves=hidden_for_ten(centre) if case == "hidden" else lambda time: (),
        wild=0.02 if case == "wild" else 0.0,
        seed=seed,
    ) as (_, _, frames):
        return frames(70)


def faults(case: str, seen: Seen) -> list[str]:
    """Return what a case shows besides distances that it must not."""
    found = []
    if case == "hidden":
        held = [step for step in seen.steps if step.state == "holding"]
        if not 8 <= len(held) <= 12 or any(step.sent for step in held):
            found.append(f"held for {len(held)} pictures")
    sent = np.array([s.command for s in seen.steps if s.sent and s.state == "pointing"])
    jump = np.linalg.norm(np.diff(sent, axis=0), axis=1).max() if len(sent) > 1 else 0.0
    if jump > LARGEST_JUMP:
        found.append(f"a command jumped {1e3 * jump:.1f} mm")
    return found


def seconds_of_pulses(centre: np.ndarray) -> float:
    """Return how long the board goes on with its pulses after the cable was cut, s."""
    with pointing(lambda time: centre) as (simulator, _, frames):
        frames(30)
        simulator.set("cable", 0)
        cut = simulator.now()
        try:
            frames(5)
        except LinkError:
            pass
        else:
            return np.inf
        count = simulator.state()["pulses0"]
        while simulator.now() < cut + 10:
            simulator.run(0.05)
            if simulator.state()["pulses0"] == count:
                break
            count = simulator.state()["pulses0"]
        ended = simulator.now() - cut
        simulator.run(0.5)
        stays = simulator.state()["pulses0"] == count
        simulator.set("cable", 1)
        return ended if stays else np.inf


def main() -> int:
    """Print a row a fruit, and fail where the acceptance list is not met."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fruits", type=int, default=20)
    parser.add_argument("--cases", nargs="+", choices=CASES, default=CASES)
    given = parser.parse_args()
    failed = 0
    for case, limit in LIMITS.items():
        if case not in given.cases:
            continue
        worst, settled, nearest, cpu = 0.0, 0.0, np.inf, []
        for seed, centre in enumerate(fruits(given.fruits)):
            seen = run(case, centre, seed)
            off, time = seen.to_stand_off(), np.array(seen.time)
            late = off[time > 1.5].max()
            gaps = np.nan_to_num([step.gap for step in seen.steps], nan=0.0)
            before = float((seen.to_surface() - gaps).min())
            other = faults(case, seen)
            good = late < limit and before > -0.002 and not other
            failed += not good
            if not good:
                print(f"{case} {seed} {centre}: {1e3 * late:.2f} mm, {1e3 * before:.2f} mm", *other)
            worst, nearest = max(worst, late), min(nearest, before)
            out = np.nonzero(off >= limit)[0]
            settled = max(settled, float(time[min(out[-1] + 1, len(off) - 1)]) if len(out) else 0.0)
            cpu += [step.seconds for step in seen.steps]
        print(
            f"{case}: off the stand-off point <= {1e3 * worst:.2f} mm ({1e3 * limit:g} allowed), "
            f"settled in <= {settled:.2f} s, nearest {1e3 * nearest:+.2f} mm beyond the gap, "
            f"CPU a frame {1e3 * np.median(cpu):.1f}, 95 % {1e3 * np.percentile(cpu, 95):.1f} ms",
            flush=True,
        )
    if CABLE in given.cases:
        ended = [seconds_of_pulses(centre) for centre in fruits(given.fruits)]
        failed += sum(not 4.9 < seconds < 5.3 for seconds in ended)
        print(f"{CABLE}: pulses end after {min(ended):.2f} to {max(ended):.2f} s (5 wanted)")
    cases = len(given.cases) * given.fruits
    print(f"radius {1e3 * RADIUS:g} mm; {failed} of {cases} not as wanted")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
