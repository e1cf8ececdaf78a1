"""
Tune gains
==========

The feedback laws (state space, static gain, IK-PID) stand and fall with their gains. Here they
are found for an arm, written to a file and used; the search is short, so that the page is made
in seconds.
"""

# %%
# Search
# ------
#
# 100 training goals and 800 gain sets. A good search takes minutes: the defaults of
# `agrik_fast.tuning.Tuning` are those of ``agrik-fast tune``.

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import agrik_fast as ik
from agrik_fast.solvers import StateSpace, StaticGain, gain_file
from agrik_fast.tuning import Tuning, goals, tune

arm = ik.Robot.load("hydrolek")
quick = Tuning(solver="static-gain", goals=100, evaluations=800, runs=1, refinement=200)
content = tune(arm, quick)
held = content.success
print(f"{held.solved} of {held.goals} goals that took no part in the search are reached")

# %%
# Keep and use
# ------------
#
# Gains are tuned for an arm, a start and a number of steps; ``as_tuned=True`` takes them so.

path = Path(tempfile.mkdtemp()) / "gains.toml"
gain_file.write(path, content)
tuned = StaticGain.load(path, as_tuned=True)

# %%
# Better than before?
# -------------------
#
# A thousand goals, none of which the search has seen, beside gains of another law that are bundled
# for this arm and took a long search.

targets = goals.joint_uniform(arm, 1000, seed=7)
figure, axis = plt.subplots(figsize=(6.5, 3.2), layout="constrained")
for name, solver in (
    ("static gain, seconds of search", tuned),
    ("state space, bundled", StateSpace.load("hydrolek_full90_cma", as_tuned=True)),
):
    result = arm.ik(targets, solver=solver, position_tolerance=1e-3)
    steps = np.sort(result.iterations[result.success])
    axis.step(steps, np.arange(1, len(steps) + 1), where="post", label=name)
    print(f"{name:30s} {result.success.mean():.1%} reached, median {np.median(steps):.0f} steps")
axis.set(xscale="log", xlabel="steps", ylabel="goals of 1,000 reached by then")
axis.legend()

# %%
# On the command line: ``agrik-fast tune hydrolek --solver static-gain -o gains.toml``, which can
# be interrupted and resumed. :doc:`../methods/tuning` tells what the search does, and
# :doc:`tutorial_7_compare` what else there is.
