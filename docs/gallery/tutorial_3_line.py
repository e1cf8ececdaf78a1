"""
A line with speed limits, as a JointTrajectory
==============================================

The tool goes along a straight line; the time law makes it as quick as the joints allow; the result
is played by others as a ROS ``trajectory_msgs/JointTrajectory``.
"""

# %%
# The line
# --------
#
# `Robot.line` starts from a posture and leads the tool straight to a point or a pose. ``success``
# is False, and the path ends early, where the line cannot be followed.

import json
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import agrik_fast as ik
from agrik_fast import motion

arm = ik.Robot.load("panda")
start = arm.joint_values({"panda_joint2": -0.4, "panda_joint4": -2.0, "panda_joint6": 1.8})
end = arm.fk(start)
end[:3, 3] += [0.10, 0.30, -0.10]
path = arm.line(start, end)
print(path, f"{path.lengths.sum():.3f} m")

# %%
# How fast may it go?
# -------------------
#
# Limits of velocity, acceleration and jerk come from the robot's file; what is missing there is
# given to `agrik_fast.motion.time_law`. Here the tool may not be faster than 0.25 m/s either.

print("velocity limits [rad/s]:", arm.velocity_limits)
trajectory = motion.time_law(arm, path, speed=0.25, rate=125)
print(trajectory)

# %%
# The tool is on the line all the time, and no limit is exceeded:

way = arm.fk(trajectory.positions)[:, :3, 3] - arm.fk(start)[:3, 3]
along = end[:3, 3] - arm.fk(start)[:3, 3]
off = np.linalg.norm(np.cross(way, along / np.linalg.norm(along)), axis=1)
print(f"off the line by {1e9 * off.max():.0f} nm at most")
used = np.abs(trajectory.velocities).max(axis=0) / arm.velocity_limits
print("share of each joint's velocity limit:", used.round(2))

figure, (above, middle, below) = plt.subplots(
    3, 1, figsize=(6.5, 5.4), layout="constrained", sharex=True
)
speed = np.linalg.norm(np.gradient(way, trajectory.times, axis=0), axis=1)
above.plot(trajectory.times, speed)
above.axhline(0.25, color="C1", linewidth=0.8)
above.set_ylabel("tool [m/s]")
middle.plot(trajectory.times, trajectory.velocities, label=arm.joint_names)
middle.set_ylabel("joints [rad/s]")
below.plot(trajectory.times, trajectory.accelerations)
below.set(ylabel="joints [rad/s²]", xlabel="time [s]")
figure.legend(loc="outside lower center", ncols=4)

# %%
# For others to play
# ------------------
#
# The suffix says what is written: CSV, Parquet and NPZ hold the points as a table, JSON and YAML
# have the shape of a ROS message; `Trajectory.write_bag` makes a ROS 2 bag (extra ``ros``).

folder = Path(tempfile.mkdtemp())
trajectory.save(folder / "line.json")
trajectory.save(folder / "line.csv")
message = json.loads((folder / "line.json").read_text())
print(message["joint_names"])
print(len(message["points"]), "points, the last at", message["points"][-1]["time_from_start"])

# %%
# A line that leaves the workspace ends where it does, and says why:

end[0, 3] += 1.0
short = arm.line(start, end)
print(short.success, ik.Status(int(short.status[-1])).name, len(short), "postures")

# %%
# :doc:`../paths` says how a path is followed, :doc:`../trajectories` what the time law does.
