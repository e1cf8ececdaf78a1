"""
A million targets
=================

Poses in, joint values out, a million at a time; then the same when they do not fit memory, and
from file to file.
"""

# %%
# Targets
# -------
#
# A million poses that the arm can reach, made by forward kinematics, and every thousandth of them
# pushed out of reach.

import tempfile
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import agrik_fast as ik
from agrik_fast.jobs import SolveRequest, solve_file

arm = ik.Robot.load("ur5")
poses = arm.fk(arm.random_q(1_000_000, seed=1))  # (1000000, 4, 4)
poses[::1000, :3, 3] *= 3

# %%
# One call
# --------
#
# All processors work; the answers are the same bits for any number of threads.

begin = time.perf_counter()
result = arm.ik(poses, seed=2)
seconds = time.perf_counter() - begin
print(result)
print(f"{len(poses) / seconds:,.0f} poses a second on {ik.get_num_threads()} threads")

# %%
# What came of each is a code, so a million answers are counted at once.

codes, counts = np.unique(result.status, return_counts=True)
for code, count in zip(codes, counts, strict=True):
    print(f"{ik.Status(int(code)).name:15s} {count:8d}")

# %%
# ``success`` is True only where a forward kinematics of the answer met the tolerance within the
# limits. Check it with your own:

solved = result.success
off = np.linalg.norm(arm.fk(result.q[solved])[:, :3, 3] - poses[solved, :3, 3], axis=1)
print(f"worst of {solved.sum()} solved: {off.max():.1e} m")

figure, axis = plt.subplots(figsize=(6.5, 3), layout="constrained")
axis.hist(np.log10(np.maximum(off, 1e-17)), bins=60)
axis.axvline(-6, color="C1", label="tolerance")
axis.set(xlabel="position error [m], as power of ten", ylabel="targets")
axis.legend()

# %%
# More than memory holds
# ----------------------
#
# Any iterable of chunks will do; the next chunk is solved while you look at this one.


def chunks():
    for number in range(4):
        yield arm.fk(arm.random_q(50_000, seed=number))


print(sum(int(part.success.sum()) for part in arm.ik_stream(chunks(), seed=3)))

# %%
# From file to file
# -----------------
#
# What ``agrik-fast solve ur5 poses.npy -o joints.parquet`` does on the command line is
# `agrik_fast.jobs.solve_file` in Python: constant memory for any number of rows. Beyond one
# machine, see :doc:`../cluster`.

folder = Path(tempfile.mkdtemp())
np.save(folder / "poses.npy", poses[:100_000])
summary = solve_file(
    SolveRequest(robot="ur5", targets=folder / "poses.npy", output=folder / "joints.npy")
)
print(summary.rows, summary.solved)
