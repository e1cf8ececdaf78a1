"""
A 1 kHz control loop
====================

A thousand targets a second, one at a time: no memory taken after the first call, every answer the
continuation of the one before, and a status for each.
"""

# %%
# A solver for one target
# -----------------------
#
# `Robot.solver` reads all options once. Its ``solve`` gives the same bits as `Robot.ik`.

import time

import matplotlib.pyplot as plt
import numpy as np

import agrik_fast as ik

arm = ik.Robot.load("panda")
solver = arm.solver(position_tolerance=1e-6, seed=1)

# %%
# A moving target
# ---------------
#
# The tool draws a figure of eight, 20 cm wide, in two seconds: 2,000 targets.

start = np.array([0.0, -0.4, 0.0, -2.0, 0.0, 1.8, 0.8])
home = arm.fk(start)
turn = 2 * np.pi * np.arange(2000) / 2000
poses = np.repeat(home[None], len(turn), axis=0)
poses[:, 1, 3] += 0.10 * np.sin(turn)
poses[:, 2, 3] += 0.05 * np.sin(2 * turn)

# %%
# The loop
# --------
#
# Each target starts from the last answer, so that the arm goes on from where it is. What takes a
# control loop's time is measured here; in a real one, wait for the next tick between two calls.

q = start
answers = np.empty((len(poses), arm.dof))
micros = np.empty(len(poses))
for row, pose in enumerate(poses):
    begin = time.perf_counter()
    if solver.solve(pose, q):
        q = solver.q
    micros[row] = 1e6 * (time.perf_counter() - begin)
    answers[row] = q

print(f"median {np.median(micros):.1f} us, 99 % below {np.percentile(micros, 99):.1f} us of 1000")
print(f"largest step of a joint: {np.degrees(np.abs(np.diff(answers, axis=0)).max()):.2f} degrees")

# %%
# What came out
# -------------

figure, (above, below) = plt.subplots(2, 1, figsize=(6.5, 4.6), layout="constrained", sharex=True)
above.plot(np.arange(len(poses)) / 1000, np.degrees(answers), label=arm.joint_names)
above.set(ylabel="joints [degrees]")
figure.legend(loc="outside lower center", ncols=4)
below.semilogy(np.arange(len(poses)) / 1000, micros)
below.axhline(1000, color="C1", label="a tick at 1 kHz")
below.set(xlabel="time [s]", ylabel="time of a call [µs]")
below.legend()

# %%
# A redundant arm drifts: after one round the tool is back where it was, the joints need not be.

print(np.degrees(answers[-1] - start).round(2))

# %%
# When the target jumps
# ---------------------
#
# With ``max_change`` no joint moves further in one call than it may: the arm goes towards a
# target that it cannot have at once, and the status says `HELD` until it is there.

careful = arm.solver(max_change=0.01, seed=1)
jumped = home.copy()
jumped[1, 3] += 0.15
q, calls = start, 0
while not careful.solve(jumped, q):
    q, calls = careful.q, calls + 1
    if calls == 1:
        print("first call:", ik.Status(careful.status).name)
print(f"there after {calls} more calls, {calls} ms at 1 kHz")

# %%
# A target that nobody can reach holds the arm where it comes nearest:

jumped[0, 3] = 2.0
for _ in range(300):
    careful.solve(jumped, q)
    q = careful.q
print(ik.Status(careful.status).name, f"{careful.position_error:.3f} m short")

# %%
# A path that is known beforehand is better given as a whole: `Robot.follow` bounds every joint's
# step and names the places where the arm has to jump (:doc:`../paths`).
