"""
A straight line
===============

The tool goes along a straight line; every joint moves smoothly, or the page says where it cannot.
"""

# %%
# The line
# --------

import matplotlib.pyplot as plt
import numpy as np

import agrik_fast as ik

arm = ik.Robot.load("ur5")
start = np.radians([30.0, -100.0, 110.0, -100.0, -90.0, 0.0])
begin = arm.fk(start)
poses = np.repeat(begin[None], 101, axis=0)
poses[:, :3, 3] += np.linspace(0, 1, 101)[:, None] * [0.25, -0.30, 0.10]

# %%
# Follow it
# ---------
#
# `Robot.follow` solves each pose from the posture before and keeps every joint below the step that
# it is given; ``discontinuity`` marks the places where no such posture exists.

path = arm.follow(poses, start, max_joint_step=0.05)
print(path)
print("largest step:", np.degrees(np.abs(path.joint_step).max()).round(2), "degrees")

figure, axis = plt.subplots(figsize=(7, 3.4), layout="constrained")
axis.plot(np.degrees(path.q), label=arm.joint_names)
axis.set(xlabel="pose along the line", ylabel="joint [degrees]")
axis.legend(fontsize=7, ncols=3)

# %%
# :doc:`../paths` says how a path is followed.
