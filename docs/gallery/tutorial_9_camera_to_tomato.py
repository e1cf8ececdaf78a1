"""
From a camera to a tomato
=========================

A picture, the red fruit in it, where that is in space, and the arm that points at it. The picture
is rendered here, so that the truth is known; a camera's or a file's goes the same way.
"""

# %%
# A picture
# ---------
#
# A ripe tomato of 3 cm radius before a wall, half behind a leaf, seen by a camera above the arm's
# base. ``pose`` is the camera in the arm's frame: x right, y down, z forward in the picture.

import matplotlib.pyplot as plt
import numpy as np

from agrik_fast import vision
from agrik_fast.arms import TomatoArm

RADIUS = 0.03
tomato = vision.Fruit((0.22, 0.04, 0.10), RADIUS)
leaf = vision.Leaf((0.17, 0.065, 0.11), along=(0.0, 1.0, 0.3), normal=(-1.0, 0.0, 0.1))
wall = vision.Wall(point=(0.55, 0.0, 0.0), normal=(-1.0, 0.0, 0.0))
light = vision.Look(light=(-0.6, 0.2, 0.75))
camera = vision.paper_camera()
pose = vision.looking_at([-0.10, 0.0, 0.14], [0.25, 0.0, 0.06])
picture = vision.render(vision.Scene((tomato,), (leaf,), wall, light), camera, pose=pose)

# %%
# Find the fruit
# --------------
#
# The detector fits a cone to the outline that is visible, which is exact for a sphere whatever the
# perspective; the status says whether enough of it was seen.

found = vision.Detector(camera).detect(picture.image)
for each in found:
    print(
        f"{each.status.name}: at pixel {each.uv.round(1)}, {each.radius_px:.1f} pixels in radius, "
        f"{each.cover:.0%} of the outline seen"
    )

figure, axis = plt.subplots(figsize=(6, 4.5), layout="constrained")
axis.imshow(vision.annotated(picture.image, camera, found)[..., ::-1])  # blue, green, red
axis.set_axis_off()

# %%
# Where it is
# -----------
#
# A known radius makes a distance of the angle in which the fruit is seen; the camera's pose brings
# that into the arm's frame. An error of the radius is passed on in full: 5 % too large a tomato is
# thought 5 % too far away.

best = found[0]
centre = pose[:3, :3] @ best.centre(RADIUS) + pose[:3, 3]
print(
    "found at",
    centre.round(4),
    "m, off by",
    f"{1e3 * np.linalg.norm(centre - tomato.centre):.1f} mm",
)

# %%
# Point at it
# -----------
#
# The arm's own closed form takes the position; stop one radius and a centimetre before the centre.

arm = TomatoArm()
direction = centre / np.linalg.norm(centre)
before = centre - (RADIUS + 0.01) * direction
answer = arm.solve(before)
print("reached:", bool(answer.success), "at", np.degrees(answer.q).round(1), "degrees")
print(
    "distance from the skin:",
    f"{1e3 * (np.linalg.norm(arm.fk(answer.q) - tomato.centre) - RADIUS):.1f} mm",
)
