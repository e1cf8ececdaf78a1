"""Where a camera is: on the arm by Park's method, beside it by points that the tip touches."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, float_array
from ..errors import ArgumentError
from ._errors import CalibrationRefusedError

__all__ = ["CameraPose", "eye_to_hand", "hand_eye"]

_FEWEST_POINTS = 6
_PARALLEL = 0.1
# Rounds of refinement, the step at which it ends, and what counts as no error at all.
_ROUNDS, _STILL, _NOTHING = 12, 1e-9, 1e-12
# What a radian of error may count, m: between a board at arm's length and one at a finger's.
_RADIAN = (0.01, 1.0)


@dataclass(frozen=True)
class CameraPose:
    """Where a camera is, and how well the measurements agree on it.

    Attributes
    ----------
    pose : ndarray, shape (4, 4)
        Of the camera, in the gripper's frame (`hand_eye`) or the arm's (`eye_to_hand`).
    rotation_residual : float, rad
        Root mean square over pairs of poses; 0 for touched points.
    translation_residual : float, m
        The same, or root mean square of the points' distances.
    worst : float, m
        The largest of them.

    Examples
    --------
    >>> from agrik_fast.vision import eye_to_hand
    >>> points = np.random.default_rng(1).uniform(size=(6, 3))
    >>> bool(eye_to_hand(points, points).worst < 1e-9)
    True
    """

    pose: FloatArray
    rotation_residual: float
    translation_residual: float
    worst: float


def _poses(name: str, value: ArrayLike) -> FloatArray:
    poses = float_array(name, value)
    if poses.ndim != 3 or poses.shape[1:] != (4, 4) or not np.isfinite(poses).all():
        raise ArgumentError(name, f"shape {poses.shape}", "finite poses, shape (n, 4, 4)")
    turns = poses[:, :3, :3]
    off = np.abs(turns @ turns.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2), initial=0.0)
    if (off > 1e-3).any() or (np.linalg.det(turns) < 0).any():
        worst = int(off.argmax()) if len(off) else 0
        raise ArgumentError(f"{name}[{worst}]", "a matrix that is no pose", "a rigid pose")
    return poses


def _logs(turns: FloatArray) -> FloatArray:
    """Return the rotation vectors of rotation matrices, shape (n, 3)."""
    # By the quaternion, which is sure for half turns as well.
    k = np.zeros((len(turns), 4, 4))
    m = turns.transpose(1, 2, 0)
    k[:, 0, 0] = m[0, 0] - m[1, 1] - m[2, 2]
    k[:, 1, 0], k[:, 1, 1] = m[0, 1] + m[1, 0], m[1, 1] - m[0, 0] - m[2, 2]
    k[:, 2, 0], k[:, 2, 1] = m[0, 2] + m[2, 0], m[1, 2] + m[2, 1]
    k[:, 2, 2] = m[2, 2] - m[0, 0] - m[1, 1]
    k[:, 3, 0], k[:, 3, 1] = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0]
    k[:, 3, 2], k[:, 3, 3] = m[1, 0] - m[0, 1], m[0, 0] + m[1, 1] + m[2, 2]
    best = np.linalg.eigh(k)[1][:, :, -1]
    axes, cosine = best[:, :3] * np.where(best[:, 3:] >= 0, 1.0, -1.0), np.abs(best[:, 3])
    sizes = np.linalg.norm(axes, axis=1)
    # Twice the axis where there is hardly a turn.
    factor = np.where(sizes < 1e-15, 2.0, 2 * np.arctan2(sizes, cosine) / np.maximum(sizes, 1e-15))
    return np.asarray(axes * factor[:, None])


def _turn_between(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the rotation that turns rows of `first` into those of `second` best."""
    u, _, v = np.linalg.svd(second.T @ first)
    sign = np.sign(np.linalg.det(u @ v))
    return np.asarray(u @ np.diag([1.0, 1.0, sign]) @ v)


def _middle(poses: FloatArray) -> FloatArray:
    """Return the pose next to many that are nearly the same."""
    u, _, v = np.linalg.svd(poses[:, :3, :3].mean(axis=0))
    mean = np.eye(4)
    mean[:3, :3] = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v))]) @ v
    mean[:3, 3] = poses[:, :3, 3].mean(axis=0)
    return mean


def _cross(vectors: FloatArray) -> FloatArray:
    """Return the matrices that multiply crosswise, shape (n, 3, 3)."""
    x, y, z = vectors.T
    zero = np.zeros(len(vectors))
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.asarray(np.array(rows).transpose(2, 0, 1))


def _refined(gripper: FloatArray, board: FloatArray, camera: FloatArray) -> FloatArray:
    """Return the camera's pose by which the board's are told best, from a first one.

    Every measured pose is once in the sum, where pairs hold it many times, and its place tells of
    the rotation as well. What a rotation counts against a place follows from how much is left of
    either, so that nobody has to know the noise.
    """
    count = len(gripper)
    turns = gripper[:, :3, :3]
    still = _middle(gripper @ camera @ board)
    for _ in range(_ROUNDS):
        told = np.linalg.inv(gripper @ camera) @ still
        turn = _logs(board[:, :3, :3] @ told[:, :3, :3].transpose(0, 2, 1))
        shift = board[:, :3, 3] - told[:, :3, 3]
        turned, shifted = float(np.sqrt(np.mean(turn**2))), float(np.sqrt(np.mean(shift**2)))
        if turned < _NOTHING and shifted < _NOTHING:
            break
        radian = min(max(shifted / max(turned, _NOTHING), _RADIAN[0]), _RADIAN[1])
        # To first order: small turns and shifts of the camera in the gripper's frame, then those
        # of the board in the base's.
        rows = np.zeros((count, 6, 12))
        back = camera[:3, :3].T
        rows[:, :3, :3] = radian * np.eye(3)
        rows[:, :3, 6:9] = -radian * told[:, :3, :3]
        rows[:, 3:, :3] = -_cross(told[:, :3, 3])
        rows[:, 3:, 3:6] = back
        rows[:, 3:, 9:] = -back @ turns.transpose(0, 2, 1)
        left = np.concatenate([radian * turn, shift], axis=1)
        step = -np.linalg.lstsq(rows.reshape(-1, 12), left.ravel(), rcond=None)[0]
        camera, still = _moved(camera, step[:6]), _moved(still, step[6:])
        if np.abs(step).max() < _STILL:
            break
    return camera


def _moved(pose: FloatArray, step: FloatArray) -> FloatArray:
    """Return a pose, turned in its own frame and shifted in the one that it is told in."""
    angle = float(np.linalg.norm(step[:3]))
    axis = step[:3] / angle if angle > 0 else np.zeros(3)
    k = _cross(axis[None])[0]
    turn = np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
    moved = pose.copy()
    moved[:3, :3] = pose[:3, :3] @ turn
    moved[:3, 3] += step[3:]
    return moved


def hand_eye(gripper: ArrayLike, board: ArrayLike) -> CameraPose:
    """Return the pose of a camera that the gripper carries.

    A X = X B for all pairs of poses: A how the gripper moved, B how the board did in the camera's
    frame. The rotation is that between the rotation vectors, then the place by least squares (Park
    and Martin). From there the camera's and the board's pose are moved until the measured poses of
    the board are told best, rotations and places weighted by what is left of them.

    Parameters
    ----------
    gripper : array_like, shape (n, 4, 4), m
        Poses of the gripper in the arm's base, n >= 3; 15 with turns by up to 45 degrees about all
        axes are advised.
    board : array_like, shape (n, 4, 4), m
        Poses of a board that stands still, in the camera's frame, see `board_pose`.

    Raises
    ------
    ArgumentError
        A matrix is no pose, or their numbers differ.
    CalibrationRefusedError
        Fewer than 3 poses, or all rotations are about parallel axes: then nothing tells where the
        camera is along them. The tomato arm's shoulder and elbow are so: use `eye_to_hand`.

    Examples
    --------
    >>> from agrik_fast.vision import hand_eye
    >>> turns = np.random.default_rng(1).uniform(-0.5, 0.5, size=(6, 3))
    >>> gripper = ik.rotations.pose(0.2 * turns, axis_angle=turns)
    >>> board = np.linalg.inv(gripper) @ ik.rotations.pose([0.5, 0.0, 0.0])
    >>> hand_eye(gripper, board).pose.round(6).tolist() == np.eye(4).tolist()
    True
    """
    g, c = _poses("gripper", gripper), _poses("board", board)
    if len(g) != len(c):
        raise ArgumentError("board", f"{len(c)} poses", f"as many as gripper, {len(g)}")
    if len(g) < 3:
        raise CalibrationRefusedError(f"{len(g)} poses were given, 3 or more are needed")
    i, j = (np.array(each) for each in zip(*combinations(range(len(g)), 2), strict=True))
    a, b = np.linalg.inv(g[j]) @ g[i], c[j] @ np.linalg.inv(c[i])
    alphas, betas = _logs(a[:, :3, :3]), _logs(b[:, :3, :3])
    sizes = np.linalg.norm(alphas, axis=1)
    axes = alphas[sizes > 1e-6] / sizes[sizes > 1e-6][:, None]
    spread = np.linalg.svd(axes, compute_uv=False) / np.sqrt(max(len(axes), 1))
    if len(axes) < 2 or spread[1] < _PARALLEL:
        raise CalibrationRefusedError(
            "all rotations of the gripper are about parallel axes, so the camera's place along "
            "them cannot be told: turn it about two axes or more, or use eye_to_hand"
        )
    turn = _turn_between(betas, alphas)
    rows = (a[:, :3, :3] - np.eye(3)).reshape(-1, 3)
    right = (b[:, :3, 3] @ turn.T - a[:, :3, 3]).ravel()
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, np.linalg.lstsq(rows, right, rcond=None)[0]
    pose = _refined(g, c, pose)
    turn, place = pose[:3, :3], pose[:3, 3]
    right = (b[:, :3, 3] @ turn.T - a[:, :3, 3]).ravel()
    off = np.linalg.norm(alphas - betas @ turn.T, axis=1)
    shifts = np.linalg.norm((rows @ place - right).reshape(-1, 3), axis=1)
    return CameraPose(
        pose,
        float(np.sqrt(np.mean(off**2))),
        float(np.sqrt(np.mean(shifts**2))),
        float(shifts.max()),
    )


def eye_to_hand(camera: ArrayLike, base: ArrayLike) -> CameraPose:
    """Return the pose of a camera that stands beside the arm, by points that the tip touched.

    The default for the tomato arm, whose three joints do not turn about enough axes for
    `hand_eye`. The best rigid fit (Kabsch).

    Parameters
    ----------
    camera : array_like, shape (n, 3), m
        Where the points are in the camera's frame, n >= 6.
    base : array_like, shape (n, 3), m
        Where the tip was, in the arm's.

    Raises
    ------
    ArgumentError
        Shapes differ or are others.
    CalibrationRefusedError
        Fewer than 6 points, or all on a line.

    Examples
    --------
    >>> from agrik_fast.vision import eye_to_hand
    >>> points = np.random.default_rng(1).uniform(size=(6, 3))
    >>> (eye_to_hand(points, points + [0.1, 0.0, 0.0]).pose[:3, 3].round(6) + 0.0).tolist()
    [0.1, 0.0, 0.0]
    """
    seen, touched = float_array("camera", camera), float_array("base", base)
    for name, value in (("camera", seen), ("base", touched)):
        if value.ndim != 2 or value.shape[1] != 3 or not np.isfinite(value).all():
            raise ArgumentError(name, f"shape {value.shape}", "finite points, shape (n, 3)")
    if len(seen) != len(touched):
        raise ArgumentError("base", f"{len(touched)} points", f"as many as camera, {len(seen)}")
    if len(seen) < _FEWEST_POINTS:
        raise CalibrationRefusedError(
            f"{len(seen)} touched points were given, {_FEWEST_POINTS} or more are needed"
        )
    middle, goal = seen.mean(axis=0), touched.mean(axis=0)
    for value in (seen - middle, touched - goal):
        sizes = np.linalg.svd(value, compute_uv=False)
        if sizes[1] < 1e-3 * max(sizes[0], 1e-12):
            raise CalibrationRefusedError("the touched points are all on one line")
    turn = _turn_between(seen - middle, touched - goal)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, goal - turn @ middle
    off = np.linalg.norm(seen @ turn.T + pose[:3, 3] - touched, axis=1)
    return CameraPose(pose, 0.0, float(np.sqrt(np.mean(off**2))), float(off.max()))
