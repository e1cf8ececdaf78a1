"""
Drive the simulated strawberry arm
==================================

The rig of the strawberry paper: three slides with encoders and three servos on an Arduino Mega.
Here the board's own program runs in a simulator; on a real port the lines are the same.
"""

# %%
# Connect and home
# ----------------
#
# ``simulated`` would do as a port; the object is made here, so that it can be asked for its
# trace. The program is compiled from ``firmware/`` when it is first needed (``make firmware``
# installs the compiler). Time passes only while somebody waits for the board, so that every run
# is the same.

import matplotlib.pyplot as plt
import numpy as np

from agrik_fast.drivers import OutOfReachError, Simulator, StrawberryRig

simulator = Simulator("strawberry")
rig = StrawberryRig(simulator)
print(rig.connect())
rig.home()
print(rig.status())

# %%
# Pick
# ----
#
# `StrawberryRig.pick` carries out the paper's command sequence: open, over the fruit, down,
# close. Both ways are checked against plant and bed before anything moves.

run = rig.pick(target=[0.426, 0.345, -0.3316])
print(f"{run.seconds:.1f} s")
for step in run.steps:
    print(f"{step.axis:8s} to {step.target:8.4f}   {step.begin:6.2f} to {step.end:6.2f} s")

# %%
# Where it stands, by its encoders, and what the arm's kinematics make of that:

print(np.round(rig.status().q, 4))

# %%
# And back
# --------

back = rig.reset()

figure, axis = plt.subplots(figsize=(6.5, 3.4), layout="constrained")
names = list(dict.fromkeys(step.axis for step in (*run.steps, *back.steps)))
for step in (*run.steps, *back.steps):
    color = "C0" if step in run.steps else "C1"
    axis.barh(names.index(step.axis), step.end - step.begin, left=step.begin, color=color)
axis.set_yticks(range(len(names)), names)
axis.set_xlabel("time [s]")
axis.set_title("pick (blue) and reset (orange)")

# %%
# What cannot be done
# -------------------
#
# A target out of reach is refused before anything moves.

try:
    rig.pick(target=[0.426, 2.0, -0.33])
except OutOfReachError as error:
    print(error)
rig.close()

# %%
# On the command line: ``agrik-fast drive strawberry --port simulated --targets targets.csv``.
# :doc:`../hardware` has the wiring, the calibration and what the boards do in a fault.
