"""
Harvest a cucumber
==================

A crop as a scene, a decision for every fruit, the posture that picks it, and what is in the way
of the others.
"""

# %%
# A crop
# ------
#
# Scenes come from files or from code; `agrik_fast.collision.greenhouse` draws a row of plants
# from a seed. Each target is a grip point with the objects that may be touched there: the fruit
# and its stalk.

import matplotlib.pyplot as plt

from agrik_fast import Robot, harvest
from agrik_fast.collision import greenhouse

scene = greenhouse(seed=2, plants=6, leaves=12)
print(len(scene.objects), "objects;", len(scene.targets), "fruits:", *scene.targets)

# %%
# Which can be picked?
# --------------------
#
# `agrik_fast.harvest.plan` looks for an approach angle with the gripper alone, then for a place
# of the slide with the whole arm, and takes the posture that keeps best clear of crop and limits.

found = harvest.plan("cucumber", scene)
for name in found.names:
    one = found[name]
    status = harvest.Status(one.status).name
    clear = f"{1e3 * one.distance:.0f} mm clear" if one.status == harvest.Status.OK else ""
    print(f"{name:6s} {status:18s} {clear}")

# %%
# Look at one
# -----------

arm = Robot.load("cucumber")
first = next(name for name in found.names if found[name].status == harvest.Status.OK)
figure = plt.figure(figsize=(6.5, 5.6))
space = figure.add_subplot(projection="3d")
scene.plot(arm, found[first].q, skip=["machine"], view=(22, -120), axes=space)
space.set_title(f"cucumber picks {first}")

# %%
# What is in the way?
# -------------------
#
# For a fruit that cannot be picked: the fewest leaves without which it could be.

stuck = [name for name in found.names if found[name].status != harvest.Status.OK]
for name, answer in harvest.blockers("cucumber", scene, stuck).items():
    words = ", ".join(answer.names) if answer.names else "nothing that can be removed"
    print(f"{name}: {words}")

# %%
# Take them away, and look again:

name = next(n for n, b in harvest.blockers("cucumber", scene, stuck).items() if b.names)
leaves = harvest.blockers("cucumber", scene, [name])[name].names
again = harvest.plan("cucumber", scene.without(*leaves), [name])
print(name, harvest.Status(again.status[0]).name)

# %%
# The same on the command line is ``agrik-fast harvest scene.json -o results``, after
# ``scene.save("scene.json")``; :doc:`../harvest`
# says how the decision is made and what the statuses mean.
