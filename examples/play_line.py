"""A line of the tool as a trajectory that a controller can play, written as ROS's message.

`make run` calls this. What it writes is read back, and checked by finite differences.
"""

import json
import sys
from pathlib import Path

import numpy as np

import agrik_fast as ik
from agrik_fast import motion

RESULT = Path(__file__).resolve().parent / "results" / "line.json"
SPEED = 0.25  # m/s


def main() -> int:
    """Make, write and check the trajectory; 1 if it breaks a limit."""
    arm = ik.Robot.load("panda")
    start = arm.joint_values({"panda_joint4": -2.0, "panda_joint6": 2.0})
    line = arm.line(start, arm.fk(start)[:3, 3] + [0.0, 0.3, 0.0])
    trajectory = motion.time_law(arm, line, speed=SPEED, rate=1000.0)
    RESULT.parent.mkdir(exist_ok=True)
    trajectory.save(RESULT, force=True)

    points = json.loads(RESULT.read_text(encoding="utf-8"))["points"]
    stamps = [point["time_from_start"] for point in points]
    times = np.array([stamp["sec"] + 1e-9 * stamp["nanosec"] for stamp in stamps])
    q = np.array([point["positions"] for point in points])
    # The last interval may be a short one, in which rounding would be most of a difference.
    velocity = (np.diff(q, axis=0) / np.diff(times)[:, None])[:-1]
    acceleration = np.diff(velocity, axis=0) / np.diff(times)[:-2, None]
    tool = arm.fk(q)[:, :3, 3]
    speed = np.linalg.norm(np.diff(tool, axis=0), axis=1)[:-1] / np.diff(times)[:-1]
    shares = (
        float((np.abs(velocity) / arm.velocity_limits).max()),
        float((np.abs(acceleration) / arm.acceleration_limits).max()),
        float(speed.max() / SPEED),
    )
    print(
        f"line of 0.3 m in {trajectory.duration:.3f} s, {len(points)} points in {RESULT.name}; of "
        f"the limits of velocity, acceleration and speed at most "
        f"{shares[0]:.0%}, {shares[1]:.0%}, {shares[2]:.0%}"
    )
    return 0 if max(shares) <= 1 + 1e-3 else 1


if __name__ == "__main__":
    sys.exit(main())
