"""
Bring your own arm
==================

From a URDF to joint values in five steps: write or take the file, load it, look at what was
read, ask for a target, and keep the arm in a small file of its own.
"""

# %%
# The file
# --------
#
# Any URDF will do. This one has a turning column, an upper arm of 40 cm, a forearm of 35 cm and
# a wrist that tilts; it is written to a folder of its own here, so that the script stands alone.

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import agrik_fast as ik

URDF = """<robot name="picker">
  <link name="base_link"/> <link name="column"/> <link name="upper"/> <link name="fore"/>
  <link name="wrist"/> <link name="tool0"/>
  <joint name="turn" type="revolute">
    <parent link="base_link"/> <child link="column"/>
    <origin xyz="0 0 0.30"/> <axis xyz="0 0 1"/>
    <limit lower="-2.9" upper="2.9" effort="50" velocity="2"/>
  </joint>
  <joint name="shoulder" type="revolute">
    <parent link="column"/> <child link="upper"/>
    <axis xyz="0 1 0"/> <limit lower="-1.6" upper="1.6" effort="50" velocity="2"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/> <child link="fore"/>
    <origin xyz="0 0 0.40"/> <axis xyz="0 1 0"/>
    <limit lower="0" upper="2.6" effort="50" velocity="2"/>
  </joint>
  <joint name="tilt" type="revolute">
    <parent link="fore"/> <child link="wrist"/>
    <origin xyz="0 0 0.35"/> <axis xyz="0 1 0"/>
    <limit lower="-1.8" upper="1.8" effort="10" velocity="3"/>
  </joint>
  <joint name="flange" type="fixed">
    <parent link="wrist"/> <child link="tool0"/> <origin xyz="0 0 0.12"/>
  </joint>
</robot>
"""
folder = Path(tempfile.mkdtemp())
(folder / "picker.urdf").write_text(URDF)

# %%
# Load it
# -------
#
# The arm goes from the only root to the link that is named like a tool; ``base_link=`` and
# ``tip_link=`` choose others. Whatever was decided is in ``notes``.

arm = ik.Robot.load(folder / "picker.urdf")
print(arm)
for name, *limits in zip(arm.joint_names, arm.lower, arm.upper, strict=True):
    print(f"{name:10s}", np.degrees(limits).round(1), "degrees")
print("notes:", arm.notes)

# %%
# One target
# ----------
#
# Three numbers are a position, in metres. Four joints are one more than a position needs: the
# arm chooses. The answer says whether it was checked and holds.

result = arm.ik([0.35, 0.25, 0.55])
print(ik.Status(result.status).name, np.degrees(result.q).round(1))
print("where the tool is then:", arm.fk(result.q)[:3, 3].round(6))

# %%
# The wrist should point straight down? Four joints can do that as well: the ``Axis`` task holds
# a position and a direction of one of the tool's axes.

down = ik.tasks.Axis(tool_axis=(0, 0, 1), direction=(0, 0, -1))
from_above = arm.ik([0.35, 0.25, 0.15], task=down)
print(ik.Status(from_above.status).name, np.degrees(from_above.q).round(1))

# %%
# A target that is too far is an answer, too.

print(ik.Status(arm.ik([1.5, 0.0, 0.3]).status).name)

# %%
# Look at it
# ----------
#
# `Robot.plot` draws the chain, or the solids of an arm that has them; of several postures the last
# is drawn in full.

figure, axes = plt.subplots(subplot_kw={"projection": "3d"}, figsize=(6, 5))
arm.plot([result.q, from_above.q], targets=[[0.35, 0.25, 0.55], [0.35, 0.25, 0.15]], axes=axes)

# %%
# Keep it
# -------
#
# A robot file holds every number to the last bit, and a person can read it.

arm.save(folder / "picker.toml")
print(ik.Robot.load(folder / "picker.toml") == arm)
print((folder / "picker.toml").read_text()[:300])

# %%
# From here on: :doc:`../own-arms` has what a URDF may hold besides.
