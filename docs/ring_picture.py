"""Pictures of the ring-cut resultant, computed in plain NumPy: the ring, its polynomial, the arms.

The resultant is worked out here as `docs/methods/every-branch.md` derives it and not by the
library, so that the picture is a check as well: its zeros must stand at the branches' values.
"""

from itertools import product
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt

import agrik_fast as ik
from agrik_fast.plots import BAD, GOOD, GREY, PAGE_WIDTH, PALE, label

THIRDS = (0.0, 2.0 * np.pi / 3.0, -2.0 * np.pi / 3.0)
PARTS = np.array([[1, 1, 1], [2, -1, -1], [0, np.sqrt(3), -np.sqrt(3)]]) / 3.0
POWERS = np.array([[1, 1, 0], [0, 0, 2], [1, -1, 0]])
STILL = [2, 5, 6, 7, 10, 13]
TURNED = [0, 3, 8, 11]


def line(direction, point):
    """Return the fourteen numbers of a line with a marked point."""
    square, along = point @ point, point @ direction
    last = square * direction - 2.0 * along * point
    return np.concatenate([direction, point, [square, along], np.cross(point, direction), last])


def moved(pose, e):
    """Return the line after a motion."""
    turn, t = pose[:3, :3], pose[:3, 3]
    return line(turn @ e[:3], turn @ e[3:6] + t)


def turn_about(axis, point, angle):
    """Return the turn about a line."""
    x = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    pose = np.eye(4)
    pose[:3, :3] = np.eye(3) + np.sin(angle) * x + (1.0 - np.cos(angle)) * x @ x
    pose[:3, 3] = point - pose[:3, :3] @ point
    return pose


def axes_of(arm):
    """Return directions and points of the axes at q = 0, from the forward kinematics alone."""
    rest = arm.fk(np.zeros(arm.dof))
    lines = []
    for k in range(arm.dof):
        q = np.zeros(arm.dof)
        q[k] = 0.5 * np.pi
        quarter = arm.fk(q) @ np.linalg.inv(rest)
        turn, shift = quarter[:3, :3], quarter[:3, 3]
        skew = 0.5 * (turn - turn.T)
        axis = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
        point = np.linalg.lstsq(np.eye(3) - turn, shift, rcond=None)[0]
        lines.append((axis / np.linalg.norm(axis), point))
    return lines, rest


def resultant(arm, pose, angles):
    """Return the resultant at values of the second joint, as a share of its largest value."""
    lines, tool = axes_of(arm)
    z, origin = lines[0]
    x = np.cross([0.0, 1.0, 0.0], z)
    frame = np.eye(4)
    frame[:3, :3] = np.column_stack([x / np.linalg.norm(x), np.cross(z, x / np.linalg.norm(x)), z])
    frame[:3, 3] = origin
    into = np.linalg.inv(frame)
    g = [turn_lines(into, one) for one in lines]
    goal = into @ pose @ np.linalg.inv(tool) @ frame
    ahead = line(*g[4])
    far = PARTS @ [moved(goal @ turn_about(*g[5], -q), ahead) for q in THIRDS]
    still = np.linalg.svd(far[1:, STILL].T)[0][:, 2:].T
    columns = (far[:, TURNED] + 1j * far[:, [k + 1 for k in TURNED]]).T
    across = np.linalg.svd(columns)[0][:, 3].conj()
    values = []
    for angle in angles:
        near = np.empty((3, 3, 14))
        for (i, b), (j, c) in product(enumerate(THIRDS), enumerate(THIRDS)):
            motion = turn_about(*g[1], angle) @ turn_about(*g[2], b) @ turn_about(*g[3], c)
            near[i, j] = moved(motion, ahead)
        near = np.einsum("ai,bj,ijk->abk", POWERS @ PARTS, POWERS @ PARTS, near)
        left = near[..., STILL] @ still.T
        # The constant times (1 + x^2)(1 + y^2).
        left[np.ix_([0, 2], [0, 2])] -= still @ far[0, STILL]
        complex_row = (near[..., TURNED] + 1j * near[..., [k + 1 for k in TURNED]]) @ across
        rows = np.concatenate([left, np.stack([complex_row.real, complex_row.imag], -1)], -1)
        blocks = rows.transpose(0, 2, 1)
        matrix = np.zeros((12, 12))
        for power in range(3):
            matrix[:6, 3 * power : 3 * power + 3] = blocks[power]
            matrix[6:, 3 * power + 3 : 3 * power + 6] = blocks[power]
        values.append(np.linalg.det(matrix))
    return np.array(values) / np.abs(values).max()


def turn_lines(by, one):
    """Return a line (direction, point) in another frame."""
    direction, point = one
    return by[:3, :3] @ direction, by[:3, :3] @ point + by[:3, 3]


def draw(file: Path, save) -> None:
    """Draw the ring with its cut, the polynomial of a pose, and the arms at its roots."""
    arm = ik.Robot.load("hydrolek")
    pose = arm.fk([0.5, 0.6, -1.0, 0.4, 1.1, 0.3])
    found = arm.ik_all(pose)
    branches = found.q[found.reached]
    figure = plt.figure(figsize=(PAGE_WIDTH, 5.6), layout="constrained")
    panels = figure.subplot_mosaic([["ring", "arms"], ["curve", "curve"]])
    ring, arms, curve = panels["ring"], panels["arms"], panels["curve"]
    spots = [np.pi / 2 - 2.0 * np.pi * k / 7 for k in range(7)]
    labels = ["goal", "1", "2", "3", "4", "5", "6"]
    ring.add_patch(plt.Circle((0, 0), 1, fill=False, color=PALE))
    for spot, name in zip(spots, labels, strict=True):
        colour = {"1": BAD, "6": BAD, "2": GOOD}.get(name, GREY)
        ring.plot(np.cos(spot), np.sin(spot), "o", ms=24, color=colour)
        ring.text(np.cos(spot), np.sin(spot), name, color="w", ha="center", va="center")
    ring.text(
        0,
        0,
        "orange: eliminated\nblue: solved for\nthe goal lies\nbetween",
        ha="center",
        va="center",
    )
    ring.set(
        xlim=(-1.3, 1.3), ylim=(-1.3, 1.3), aspect="equal", title="the ring of joints and goal"
    )
    ring.axis("off")
    angles = np.linspace(-np.pi, np.pi, 721)
    value = resultant(arm, pose, angles)
    curve.plot(angles, np.sign(value) * np.abs(value) ** 0.25, color=GOOD, label="resultant")
    curve.axhline(0, color=PALE, lw=0.8)
    # Within one turn, as the curve.
    curve.plot(
        (branches[:, 1] + np.pi) % (2 * np.pi) - np.pi,
        np.zeros(len(branches)),
        "o",
        color=BAD,
        ms=4,
        label="branches of the pose",
    )
    curve.legend()
    curve.set(xlabel=label("joint 2", "rad"), ylabel="fourth root", title="the polynomial")
    for q in branches:
        points = arm.fk_links(q)[:, :3, 3]
        arms.plot(
            np.hypot(points[:, 0], points[:, 1]) * np.sign(points[:, 0]),
            points[:, 2],
            "-o",
            ms=2,
            lw=1,
        )
    arms.set(
        xlabel=label("distance from axis 1", "m"),
        ylabel=label("z", "m"),
        aspect="equal",
        title=f"{len(branches)} branches of one pose",
    )
    save(figure, file)
