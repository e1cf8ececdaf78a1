"""A second opinion on harvest postures: pose, limits and exact distance, in NumPy alone."""

from __future__ import annotations

import numpy as np

# Modified DH rows of the arm: alpha, a, d, theta, mm; the joint value is added to d or theta.
ROWS = [
    (0.0, 0.0, 0.0),
    (-np.pi / 2, 0.0, 350.0),
    (-np.pi / 2, 100.0, 0.0),
    (0.0, 250.0, 0.0),
    (-np.pi / 2, 135.0, 250.0),
    (np.pi / 2, 0.0, 0.0),
    (-np.pi / 2, 0.0, 0.0),
]
BASE = np.array([[1, 0, 0, 0], [0, 0, -1, 500], [0, 1, 0, 600], [0, 0, 0, 1]], dtype=float)
TOOL = np.array([34.0, 0.0, 235.0])
LIMITS = np.array(
    [
        [0, 1000],
        *np.radians(
            [[-160, 160], [-135, 45], [-40, 80], [-160, 160], [-120, 120], [-20, 380]]
        ).tolist(),
    ]
)
# Bodies: frame, centre and half lengths, mm.
BODIES = {
    "base": (1, (-58.5, 100, 6.5), (173.5, 100, 115.5)),
    "shoulder": (2, (38.5, 0, -40), (147.5, 109, 126)),
    "upper_arm": (3, (117, 0.5, 1.5), (204, 88.5, 149.5)),
    "elbow": (4, (61, -92, 0), (133, 164, 90)),
    "forearm": (5, (0, 0, -59), (58, 90, 128)),
    "wrist": (6, (0, -5.5, -2), (56, 89.5, 39)),
    "flange": (7, (0, 0, 70), (31, 31, 20)),
    "gripper": (7, (2.5, 0, 177.5), (72.5, 45, 87.5)),
}
MAY_TOUCH = ("gripper", "flange")


def frames(q_mm: np.ndarray) -> list[np.ndarray]:
    """Return the frames of the links in the world, mm."""
    pose, found = BASE, []
    for k, (alpha, a, d) in enumerate(ROWS):
        slide, angle = (q_mm[0], 0.0) if k == 0 else (0.0, q_mm[k])
        ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(angle), np.sin(angle)
        way = d + slide
        pose = pose @ np.array(
            [
                [ct, -st, 0, a],
                [st * ca, ct * ca, -sa, -sa * way],
                [st * sa, ct * sa, ca, ca * way],
                [0, 0, 0, 1],
            ]
        )
        found.append(pose)
    return found


def tool(q_mm: np.ndarray) -> np.ndarray:
    """Return the pose of the tool in the world, mm."""
    pose = frames(q_mm)[-1].copy()
    pose[:3, 3] += pose[:3, :3] @ TOOL
    return pose


def distance(q_mm: np.ndarray, balls: dict[str, np.ndarray], own: tuple[str, ...] = ()) -> float:
    """Return the distance of all bodies from rows x, y, z, radius by object, mm."""
    poses, least = frames(q_mm), np.inf
    for name, (frame, centre, half) in BODIES.items():
        pose = poses[frame - 1]
        for other, rows in balls.items():
            if name in MAY_TOUCH and other in own:
                continue
            local = (rows[:, :3] - pose[:3, 3]) @ pose[:3, :3] - np.array(centre)
            beyond = np.maximum(np.abs(local) - np.array(half), 0)
            least = min(least, float((np.linalg.norm(beyond, axis=1) - rows[:, 3]).min()))
    return least
