"""The tomato loop before many fruits, still and moving, with servos that tremble and without."""

import argparse
import sys

import numpy as np

from pointing import RADIUS, Seen, fruits, pointing

# Degrees that servos yield: twice their torque over the one that stalls them.
NOISE = {f"servo{i}.noise": 0.1 for i in range(3)} | {"droop0": 1.14, "droop1": 0.36}
# What is allowed, m, after 1.5 s.
LIMITS = {"still": 0.003, "trembling": 0.008, "moving": 0.010, "wild": 0.003}


def run(case: str, centre: np.ndarray, seed: int) -> Seen:
    """Return what one fruit's two seconds were like."""
    way = np.array([0.0, -0.03 * np.sign(centre[1]), 0.0]) if case == "moving" else np.zeros(3)
    with pointing(
        lambda time: centre + time * way,
        NOISE if case == "trembling" else None,
        wild=0.02 if case == "wild" else 0.0,
        seed=seed,
    ) as (_, _, frames):
        return frames(70)


def main() -> int:
    """Print a row a fruit, and fail where the acceptance list is not met."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fruits", type=int, default=20)
    given = parser.parse_args()
    failed = 0
    for case, limit in LIMITS.items():
        worst, settled, nearest, cpu = 0.0, 0.0, np.inf, []
        for seed, centre in enumerate(fruits(given.fruits)):
            seen = run(case, centre, seed)
            off, time = seen.to_stand_off(), np.array(seen.time)
            late = off[time > 1.5].max()
            gaps = np.nan_to_num([step.gap for step in seen.steps], nan=0.0)
            before = float((seen.to_surface() - gaps).min())
            good = late < limit and before > -0.002
            failed += not good
            if not good:
                print(f"{case} {seed} {centre}: {1e3 * late:.2f} mm, {1e3 * before:.2f} mm")
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
    print(f"radius {1e3 * RADIUS:g} mm; {failed} of {4 * given.fruits} not as wanted")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
