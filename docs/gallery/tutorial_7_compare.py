"""
Compare solvers
===============

One arm, the same poses, every solver that applies: how many are reached, how far off, how long.
"""

# %%
# Targets
# -------

import time

import matplotlib.pyplot as plt
import numpy as np

import agrik_fast as ik
from agrik_fast import solvers

arm = ik.Robot.load("puma560")
poses = arm.fk(arm.random_q(2000, seed=11))

# %%
# The solvers
# -----------
#
# ``lm`` is the default. Those below it take their steps differently, in the same loop; the last
# two need no step at all (closed form) or no start (a population). The feedback laws, ``ccd``
# among them, are for positions alone or want gains: :doc:`tutorial_6_tune`.

contenders = {
    "lm": "lm",
    "dls": "dls",
    "pinv": "pinv",
    "transpose": solvers.Transpose(max_restarts=2),
    "closed_form": "closed_form",
    "de": solvers.DifferentialEvolution(generations=30, max_restarts=0),
}
rows = {}
for name, solver in contenders.items():
    some = poses if name not in ("transpose", "de") else poses[:200]
    begin = time.perf_counter()
    result = arm.ik(some, solver=solver, seed=1)
    seconds = time.perf_counter() - begin
    rows[name] = result.success.mean(), 1e6 * seconds / len(some), result.position_error
    print(
        f"{name:12s} {rows[name][0]:7.1%} reached   {rows[name][1]:9.1f} us a pose   "
        f"median {np.median(rows[name][2]):.0e} m off"
    )

# %%
# Times are by the clock and on all processors of the machine that made this page: compare them
# with each other. A slow solver can be the right one where its way of moving is what is studied;
# for answers alone take ``lm``, and ``closed_form`` where the arm has one.

figure, axis = plt.subplots(figsize=(6.5, 3.2), layout="constrained")
for name, (share, micros, _) in rows.items():
    axis.plot(micros, 100 * share, "o", markersize=9, label=name)
axis.set(
    xscale="log", xlim=(1, 1e4), ylim=(0, 105), xlabel="time a pose [µs]", ylabel="reached [%]"
)
axis.legend(loc="lower left", ncols=2)

# %%
# Closed forms know every branch
# ------------------------------

branches = arm.ik_all(poses)
for count, targets in zip(*np.unique(branches.valid.sum(axis=1), return_counts=True), strict=True):
    print(f"{count} branches within the limits: {targets} targets")

# %%
# :doc:`../solvers` describes each, :doc:`../comparison` sets the library beside others.
