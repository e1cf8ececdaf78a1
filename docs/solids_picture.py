"""Pictures of solids: arms with their bodies, scenes, and how far one is from the other."""

import itertools
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import agrik_fast as ik
from agrik_fast.collision import Box, Capsule, Convex, Cover, Scene, Sphere, greenhouse
from agrik_fast.plots import BAD, FIELD, GOOD, PAGE_WIDTH, PALETTE, PNG_DPI

AROUND = np.linspace(0.0, 2 * np.pi, 13)
UP = np.linspace(-np.pi / 2, np.pi / 2, 7)


def ball(centre, radius):
    """Return the corners of patches of a sphere."""
    x = radius * np.outer(np.cos(UP), np.cos(AROUND)) + centre[0]
    y = radius * np.outer(np.cos(UP), np.sin(AROUND)) + centre[1]
    z = radius * np.outer(np.sin(UP), np.ones_like(AROUND)) + centre[2]
    return patches(np.stack([x, y, z], axis=-1))


def patches(grid):
    """Return the four-cornered patches of a grid of points."""
    parts = [grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]]
    return np.stack(parts, axis=2).reshape(-1, 4, 3)


def surface(shape):
    """Return patches that show a shape."""
    if isinstance(shape, Sphere):
        return ball(shape.centre, shape.radius)
    if isinstance(shape, Capsule):
        a, b = np.array(shape.a), np.array(shape.b)
        along = b - a
        length = np.linalg.norm(along)
        if length < 1e-9:
            return ball(a, shape.radius)
        along /= length
        side = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
        side /= np.linalg.norm(side)
        ring = np.outer(np.cos(AROUND), side) + np.outer(np.sin(AROUND), np.cross(along, side))
        rows = [a + shape.radius * (np.sin(u) * along + np.cos(u) * ring) for u in UP[:4]]
        rows += [b + shape.radius * (np.sin(u) * along + np.cos(u) * ring) for u in UP[3:]]
        return patches(np.array(rows))
    if isinstance(shape, Convex):
        from scipy.spatial import ConvexHull

        corners = np.array(shape.vertices)
        return corners[ConvexHull(corners).simplices]
    box = shape.box if isinstance(shape, Cover) else shape
    assert isinstance(box, Box)
    turn, half = np.array(box.rotation), np.array(box.half) + box.radius
    faces = []
    for axis in range(3):
        others = [k for k in range(3) if k != axis]
        for sign in (-1, 1):
            face = np.zeros((4, 3))
            face[:, axis] = sign
            face[:, others] = [[-1, -1], [1, -1], [1, 1], [-1, 1]]
            faces.append(np.array(box.centre) + face * half @ turn.T)
    return np.array(faces)


def draw(axis, shapes, color, alpha=1.0):
    """Draw shapes in one colour."""
    found = [surface(shape) for shape in shapes]
    for size in {len(part[0]) for part in found if len(part)}:
        faces = np.concatenate([part for part in found if len(part) and len(part[0]) == size])
        axis.add_collection3d(Poly3DCollection(faces, facecolors=color, alpha=alpha, shade=True))


def placed(arm, q):
    """Return the bodies of an arm where they are at a posture; its base is that of the poses."""
    frames = [np.eye(4), *arm.fk_links(q)]
    return [body.shape.moved(tidy(frames[arm.frame_number(body.frame)])) for body in arm.bodies]


def tidy(pose):
    """Return a pose whose last row is exact."""
    pose = np.array(pose)
    pose[3] = 0, 0, 0, 1
    return pose


def frame_box(axis, low, high):
    """Show a part of space, every direction at one scale."""
    axis.set_xlim(low[0], high[0])
    axis.set_ylim(low[1], high[1])
    axis.set_zlim(low[2], high[2])
    axis.set_box_aspect(np.subtract(high, low))
    axis.locator_params(nbins=3)
    axis.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")


COLUMNS = 4
POSTURES = {
    "panda": [0.0, -0.4, 0.0, -2.0, 0.0, 1.8, 0.8],
    "ur5": [0.3, -1.2, 1.2, -1.5, -1.57, 0.0],
    "puma560": [0.3, 0.9, -0.4, 0.2, 0.6, 0.0],
    "redundant7": [0.3, 0.6, 0.0, 1.2, 0.0, 0.8, 0.0],
}


def draw_bodies(file, save):
    """Draw the bodies of all bundled arms."""
    names = [name for name in ik.Robot.names() if ik.Robot.load(name).bodies]
    rows = -(-len(names) // COLUMNS)
    figure = plt.figure(figsize=(PAGE_WIDTH, 1.75 * rows))
    for place, name in enumerate(names, start=1):
        arm = ik.Robot.load(name)
        low = np.where(np.isfinite(arm.lower), arm.lower, -1.0)
        high = np.where(np.isfinite(arm.upper), arm.upper, 1.0)
        q = np.array(POSTURES.get(name, 0.5 * low + 0.5 * high))
        axis = figure.add_subplot(rows, COLUMNS, place, projection="3d")
        shapes = placed(arm, q)
        colors = plt.colormaps["viridis"](np.linspace(0.15, 0.85, len(shapes)))
        for shape, color in zip(shapes, colors, strict=True):
            draw(axis, [shape], color)
        corners = np.concatenate([surface(shape).reshape(-1, 3) for shape in shapes])
        frame_box(axis, corners.min(axis=0), corners.max(axis=0))
        # Numbers at axes as small as these could not be read: the size is told instead.
        axis.set_axis_off()
        size = np.ptp(corners, axis=0).max()
        axis.set_title(f"{name}: {len(shapes)}\n{size:.2f} m long", y=1.04)
        axis.view_init(20, -55)
    figure.subplots_adjust(left=0.0, right=1.0, bottom=0.0, top=0.94, wspace=0.0, hspace=0.3)
    save(figure, file, dpi=PNG_DPI)


def draw_greenhouse(file, save):
    """Draw the cucumber arm at a fruit, as it would reach it and as it keeps clear of leaves."""
    arm, scene = ik.Robot.load("cucumber"), greenhouse(2, 5, 12)
    aim = scene.aiming_at("F1_0")
    target = np.eye(4)
    target[:3, 0], target[:3, 1], target[:3, 2] = (0, 0, -1), (0, 1, 0), (1, 0, 0)
    target[:3, 3] = scene.targets["F1_0"].point
    turned = [target @ turn_about_x(angle) for angle in np.radians(np.arange(-60, 61, 5))]
    poses = np.array(turned)
    plain, free = arm.ik(poses), arm.ik(poses, scene=aim, prefer="clearance")
    hits = (aim.clearance(arm, plain.q) <= 0.0) & plain.success
    # Both reach the fruit from the same side, and one of them goes through leaves.
    gaps = np.where(hits & free.success, aim.clearance(arm, free.q), -1.0)
    row = int(gaps.argmax())
    assert gaps[row] > 0.0
    figure = plt.figure(figsize=(PAGE_WIDTH, 4.0))
    for place, (q, words) in enumerate(
        [(plain.q[row], "without a scene"), (free.q[row], "with the scene")], start=1
    ):
        axis = figure.add_subplot(1, 2, place, projection="3d")
        for one in scene.objects:
            if one.kind in FIELD and one.kind != "ground":
                draw(axis, one.shapes(), FIELD[one.kind], 0.35 if one.kind == "machine" else 1.0)
        found = aim.distances(arm, q)
        for shape, gap in zip(placed(arm, q), found.distance, strict=True):
            draw(axis, [shape], BAD if gap <= 0 else GOOD, 0.9)
        gap, body = float(found.distance.min()), int(found.distance.argmin())
        what = f"{found.bodies[body]}, {1e3 * gap:.0f} mm from {found.object_names[body]}"
        if gap <= 0:
            what = f"{found.bodies[body]} hits {found.object_names[body]}"
        axis.set_title(f"{words}:\n{what}")
        frame_box(axis, (-0.4, -0.7, 0.2), (1.0, 0.8, 1.9))
        axis.view_init(24, -130)
    figure.subplots_adjust(left=0.06, right=0.97, bottom=0.03, top=0.92, wspace=0.1)
    save(figure, file, dpi=PNG_DPI)


def turn_about_x(angle):
    """Return a turn about the tool's own x axis, which hangs down."""
    pose = np.eye(4)
    c, s = np.cos(angle), np.sin(angle)
    pose[1:3, 1:3] = [[c, -s], [s, c]]
    return pose


def draw_clearance(file, save):
    """Draw the distance of each body of the Panda along a move, with the nearest object."""
    arm = ik.Robot.load("panda")
    scene = Scene.load(Path(__file__).parents[1] / "examples" / "scenes" / "bench.toml")
    share = np.linspace(0.0, 1.0, 301)[:, None]
    start, goal = arm.random_q(2, seed=2)
    q = start + share * (goal - start)
    found = scene.distances(arm, q)
    figure, axis = plt.subplots(figsize=(PAGE_WIDTH, 3.2), layout="constrained")
    drawn = 0
    for k, name in enumerate(found.bodies):
        if np.isfinite(found.distance[:, k]).all() and found.distance[:, k].min() < 0.15:
            # There are more bodies than colours that can be told apart.
            look = {"color": PALETTE[drawn % 6], "linestyle": "-" if drawn < 6 else "--"}
            axis.plot(share, 1e3 * found.distance[:, k], label=name, linewidth=1, **look)
            drawn += 1
    least = scene.clearance(arm, q)
    axis.plot(share, 1e3 * least, color="black", linewidth=2.2, label="clearance")
    nearest = found.object_names[np.arange(len(q)), found.distance.argmin(axis=1)]
    changes = [0, *(np.flatnonzero(nearest[1:] != nearest[:-1]) + 1).tolist(), len(q)]
    for first, last in itertools.pairwise(changes):
        if last - first > 8:
            middle = (first + last) // 2
            axis.annotate(nearest[middle], (share[middle, 0], 1e3 * least[middle]),
                          xytext=(0, -12), textcoords="offset points", ha="center")  # fmt: skip
    axis.axhline(0.0, color=BAD, linewidth=0.8)
    axis.set_ylim(-20, 260)
    axis.set_xlabel("share of the move")
    axis.set_ylabel("distance [mm]")
    figure.legend(loc="outside right center")
    save(figure, file)
