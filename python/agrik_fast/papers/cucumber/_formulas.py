"""Appendix B of the cucumber paper, as it reads and as it holds.

Lengths in mm, angles in rad, frame 0 of the paper: z0 along the slide, y0 up. The paper's
length a_i stands in row i of the Denavit-Hartenberg table, where Craig has a_(i-1).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["LENGTHS", "MISPRINTS", "Misprint", "Pose", "forward", "random_poses"]

Array = NDArray[np.float64]


class Lengths(NamedTuple):
    """Lengths of the arm, mm; those of a sister arm, as table 1 is missing."""

    d2: float = 350.0
    a3: float = 100.0
    a4: float = 250.0
    a5: float = 135.0
    d5: float = 250.0
    tool_x: float = 34.0
    tool_z: float = 235.0


LENGTHS = Lengths()
TWISTS = (0.0, -np.pi / 2, -np.pi / 2, 0.0, -np.pi / 2, np.pi / 2, -np.pi / 2)


class Pose(NamedTuple):
    """Joint values and what follows from them, one row each.

    Attributes
    ----------
    q : ndarray, shape (n, 7)
        d1 (mm) and theta2 to theta7.
    wrist : ndarray, shape (n, 4, 4)
        Transform from frame 0 to frame 7.
    tool : ndarray, shape (n, 4, 4)
        Transform from frame 0 to the tool.
    """

    q: Array
    wrist: Array
    tool: Array


def _link(alpha: float, a: float, theta: Array, d: Array) -> Array:
    """Return Rx(alpha) Tx(a) Rz(theta) Tz(d), equation (B1)."""
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    one, zero = np.ones_like(ct), np.zeros_like(ct)
    rows = [
        [ct, -st, zero, a * one],
        [st * ca, ct * ca, -sa * one, -sa * d],
        [st * sa, ct * sa, ca * one, ca * d],
        [zero, zero, zero, one],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def links(q: Array) -> list[Array]:
    """Return the seven transforms from link to link, each (n, 4, 4)."""
    n, of = len(q), LENGTHS
    lengths = (0.0, 0.0, of.a3, of.a4, of.a5, 0.0, 0.0)
    offsets = (None, of.d2, 0.0, 0.0, of.d5, 0.0, 0.0)
    found = []
    for k in range(7):
        offset = offsets[k]
        d = q[:, 0] if offset is None else np.full(n, offset)
        theta = np.zeros(n) if k == 0 else q[:, k]
        found.append(_link(TWISTS[k], lengths[k], theta, d))
    return found


def _product(transforms: list[Array]) -> Array:
    whole = transforms[0]
    for one in transforms[1:]:
        whole = whole @ one
    return whole


def forward(q: Array) -> Pose:
    """Return the poses of joint values, equations (B2) and (B3)."""
    wrist = _product(links(q))
    return Pose(q, wrist, wrist @ _tool())


def _tool() -> Array:
    tool = np.eye(4)
    tool[:3, 3] = [LENGTHS.tool_x, 0, LENGTHS.tool_z]
    return tool


def random_poses(count: int = 10_000, seed: int = 1) -> Pose:
    """Return poses of random joint values: the slide in its stroke, angles in a whole turn."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-np.pi, np.pi, (count, 7))
    q[:, 0] = rng.uniform(0, 1000, count)
    return forward(q)


@dataclass(frozen=True)
class Misprint:
    """A formula that does not read as it holds.

    Attributes
    ----------
    place, printed, holds : str
        Where it is, how it reads in the scan, and what holds.
    unit : str
        Of the errors.
    error, corrected : callable
        Largest error of the formula as read, and as it holds, over poses.
    """

    place: str
    printed: str
    holds: str
    unit: str
    error: Callable[[Pose], float]
    corrected: Callable[[Pose], float]


def _sc(x: Array) -> tuple[Array, Array]:
    return np.sin(x), np.cos(x)


def _planar(pose: Pose) -> tuple[Array, Array]:
    """Return X and Z of (B7) and (B8) from the wrist's centre."""
    s2, c2 = _sc(pose.q[:, 1])
    px, py, pz = (pose.wrist[:, k, 3] for k in range(3))
    return c2 * px + s2 * (pose.q[:, 0] - pz) - LENGTHS.a3, py - LENGTHS.d2


def _worst(off: Array) -> float:
    return float(np.abs(off).max())


def _turn(off: Array) -> float:
    return float(np.abs((off + np.pi) % (2 * np.pi) - np.pi).max())


def _tcp(pose: Pose, product: Array) -> float:
    return _worst(product[:, :3, 3] - pose.tool[:, :3, 3])


def _b5(pose: Pose, th2: Array) -> float:
    s2, c2 = _sc(th2)
    px, pz = pose.wrist[:, 0, 3], pose.wrist[:, 2, 3]
    return _worst(-s2 * px + c2 * (pose.q[:, 0] - pz))


def _th2(pose: Pose) -> Array:
    return np.asarray(np.arctan2(pose.q[:, 0] - pose.wrist[:, 2, 3], pose.wrist[:, 0, 3]))


def _b7(pose: Pose, first: float) -> float:
    of = LENGTHS
    th3, th34 = pose.q[:, 2], pose.q[:, 2] + pose.q[:, 3]
    (_, c3), (s34, c34) = _sc(th3), _sc(th34)
    c4 = np.cos(pose.q[:, 3])
    # a5 c3 c4 - a5 s3 s4 is a5 cos(th3 + th4): the first of the two has the other length.
    value = of.a5 * c34 + (first - of.a5) * c3 * c4 - of.d5 * s34 + of.a4 * c3
    return _worst(value - _planar(pose)[0])


def _b8(pose: Pose, last: Callable[[Array], Array]) -> float:
    of = LENGTHS
    th3, th34 = pose.q[:, 2], pose.q[:, 2] + pose.q[:, 3]
    s34, c34 = _sc(th34)
    value = -of.a5 * s34 - of.d5 * c34 - of.a4 * last(th3)
    return _worst(value - _planar(pose)[1])


def _k(pose: Pose, sign: float, squares: float) -> Array:
    of = LENGTHS
    x, z = _planar(pose)
    total = x**2 + z**2 - of.a4**2 + squares * (of.a5**2 + of.d5**2)
    return np.asarray(total / (sign * 2 * of.a4))


def _b9(pose: Pose, k: Array) -> float:
    s4, c4 = _sc(pose.q[:, 3])
    return _worst(LENGTHS.a5 * c4 - LENGTHS.d5 * s4 - k)


def _th4(pose: Pose, divide: bool) -> float:
    """Return how far the nearer root of (B14) to (B18) is from theta4."""
    of = LENGTHS
    rho = float(np.hypot(of.a5, of.d5))
    k = _k(pose, 1.0, -1.0)
    sine = np.clip(k / rho if divide else np.sign(k) * np.minimum(np.abs(k), 1.0), -1, 1)
    root = np.sqrt(np.maximum(0.0, 1 - sine**2))
    both = [np.arctan2(of.a5, of.d5) - np.arctan2(sine, side * root) for side in (1, -1)]
    away = [np.abs((th - pose.q[:, 3] + np.pi) % (2 * np.pi) - np.pi) for th in both]
    return float(np.minimum(*away).max())


def _th34(pose: Pose) -> Array:
    of = LENGTHS
    x, z = _planar(pose)
    s4, c4 = _sc(pose.q[:, 3])
    m, n = of.a4 * c4 + of.a5, of.a4 * s4 - of.d5
    return np.asarray(np.arctan2(n * x - m * z, m * x + n * z))


def _element(pose: Pose, row: int) -> Array:
    """Return an element of the last column of 3_5T, the wrist seen from link 3."""
    chain = links(pose.q)
    return np.asarray(_product(chain[3:5])[:, row, 3])


def _b26(pose: Pose, first: bool) -> Array:
    """Return theta6 by (B28) with 0_5T of the joints, the slide's angle among them or not."""
    q = pose.q.copy()
    chain = links(q)
    if first:
        # There is no theta1; read as the joint that comes first, theta2 turns twice.
        chain[0] = chain[0] @ _link(-np.pi / 2, 0.0, q[:, 1], np.zeros(len(q)))
    rest = np.linalg.solve(_product(chain[:5]), pose.wrist)
    return np.asarray(np.arctan2(-rest[:, 0, 2], rest[:, 2, 2]))


def _b27(pose: Pose, row: int) -> float:
    rest = np.linalg.solve(_product(links(pose.q)[:5]), pose.wrist)
    return _turn(np.arctan2(-rest[:, row, 2], rest[:, 2, 2]) - pose.q[:, 5])


def _b23(pose: Pose, literal: bool) -> float:
    """Return the share of poses with a regular wrist that the test takes for singular."""
    rest = np.linalg.solve(_product(links(pose.q)[:4]), pose.wrist)
    a, b = rest[:, 0, 2], rest[:, 2, 2]
    regular = np.hypot(a, b) > 1e-6
    kept = (a > 0) & (b > 0) if literal else (np.abs(a) > 1e-12) | (np.abs(b) > 1e-12)
    return float((regular & ~kept).sum() / regular.sum())


def _straight(pose: Pose) -> Pose:
    q = pose.q.copy()
    q[:, 5] = 0
    return forward(q)


def _b25(pose: Pose, signs: tuple[float, float]) -> float:
    """Return how far theta5 + theta7 of straight wrists is off."""
    of = _straight(pose)
    s2, c2 = _sc(of.q[:, 1])
    r = of.wrist
    g1 = s2 * r[:, 0, 0] + c2 * r[:, 2, 0]
    g2 = s2 * r[:, 0, 1] + c2 * r[:, 2, 1]
    return _turn(np.arctan2(signs[0] * g1, signs[1] * g2) - of.q[:, 4] - of.q[:, 6])


MISPRINTS: tuple[Misprint, ...] = (
    Misprint(
        "(B2), (B3)",
        "the place of the tool's factor cannot be read; before 0_7T",
        "behind it: 0_7T 7_TCP T",
        "mm",
        lambda pose: _tcp(pose, _tool() @ pose.wrist),
        lambda pose: _tcp(pose, pose.wrist @ _tool()),
    ),
    Misprint(
        "(B6b)",
        "theta2 '+ -IT'; read as -1",
        "+ pi",
        "mm",
        lambda pose: _b5(pose, _th2(pose) - 1),
        lambda pose: _b5(pose, _th2(pose) + np.pi),
    ),
    Misprint(
        "(B7)",
        "a4 c3 c4 first",
        "a5 c3 c4",
        "mm",
        lambda pose: _b7(pose, LENGTHS.a4),
        lambda pose: _b7(pose, LENGTHS.a5),
    ),
    Misprint(
        "(B8)",
        "- a4 c3 last",
        "- a4 s3",
        "mm",
        lambda pose: _b8(pose, np.cos),
        lambda pose: _b8(pose, np.sin),
    ),
    Misprint(
        "(B10)",
        "denominator -2 a4",
        "+2 a4, minus a4^2, a5^2 and d5^2",
        "mm",
        lambda pose: _b9(pose, _k(pose, -1.0, -1.0)),
        lambda pose: _b9(pose, _k(pose, 1.0, -1.0)),
    ),
    Misprint(
        "(B13) to (B16)",
        "K and the root are lost; K for a sine",
        "K / rho and +-sqrt(1 - K^2 / rho^2), rho^2 = a5^2 + d5^2",
        "rad",
        lambda pose: _th4(pose, divide=False),
        lambda pose: _th4(pose, divide=True),
    ),
    Misprint(
        "after (B19)",
        "elements (1,4) and (3,4)",
        "(1,4) and (2,4); the element (3,4) is 0 = 0",
        "mm",
        # The element that is left out moves by so much; the one in its place never does.
        lambda pose: float(np.ptp(_element(pose, 1))),
        lambda pose: _worst(_element(pose, 2)),
    ),
    Misprint(
        "(B20)",
        "'3 4 ~': theta3 times theta4, or theta3 alone",
        "theta3 + theta4 = Atan2(.., ..), then minus theta4",
        "rad",
        lambda pose: _turn(_th34(pose) - pose.q[:, 2]),
        lambda pose: _turn(_th34(pose) - pose.q[:, 3] - pose.q[:, 2]),
    ),
    Misprint(
        "(B23a), (B23b)",
        "both elements > 0 for a regular wrist",
        "at least one of them is not zero",
        "share of regular poses lost",
        lambda pose: _b23(pose, literal=True),
        lambda pose: _b23(pose, literal=False),
    ),
    Misprint(
        "(B25)",
        "minus signs garbled",
        "Atan2(s2 r11 + c2 r31, s2 r12 + c2 r32)",
        "rad",
        lambda pose: _b25(pose, (-1.0, -1.0)),
        lambda pose: _b25(pose, (1.0, 1.0)),
    ),
    Misprint(
        "(B26)",
        "0_5T(d1, theta1, ..., theta5)",
        "0_5T(d1, theta2, ..., theta5)",
        "rad",
        lambda pose: _turn(_b26(pose, first=True) - pose.q[:, 5]),
        lambda pose: _turn(_b26(pose, first=False) - pose.q[:, 5]),
    ),
    Misprint(
        "(B27)",
        "7T1,3 without its frame; of frame 6 in place of 5",
        "Atan2(-5_7T13, 5_7T33)",
        "rad",
        lambda pose: _b27(pose, 1),
        lambda pose: _b27(pose, 0),
    ),
    Misprint(
        "section 4.1",
        "'5R PUMA' and '7R manipulator'",
        "6R PUMA 560 and P6R",
        "joints",
        lambda pose: float(abs(5 - (pose.q.shape[1] - 1))),
        lambda pose: float(abs(6 - (pose.q.shape[1] - 1))),
    ),
)
"""The thirteen places of appendix B and section 4.1 that do not read as they hold."""
