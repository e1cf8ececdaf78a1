"""The published differential evolution for redundant7 in vectorised NumPy, as a yardstick.

One array operation serves the whole population: nothing loops over individuals.
"""

from __future__ import annotations

import numpy as np

LENGTHS = {0: 0.340, 2: 0.400, 4: 0.400, 6: 0.126}
"""d of Table I, m, by joint."""
TWISTS = (-1, 1, -1, 1, -1, 1, 0)
"""alpha of Table I, in right angles."""
LIMITS = np.array([17 / 18, 2 / 3, 17 / 18, 2 / 3, 17 / 18, 2 / 3, 35 / 36]) * np.pi


def forward(q: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the axes x, y, z and the position of the tool, each of shape (3, n); q is (7, n)."""
    cosines, sines = np.cos(q), np.sin(q)
    n = q.shape[1]
    x, y, z = np.eye(3)[:, :, None].repeat(n, axis=2)
    p = np.zeros((3, n))
    for i in range(7):
        c, s = cosines[i], sines[i]
        x, y = c * x + s * y, c * y - s * x
        if i in LENGTHS:
            p = p + LENGTHS[i] * z
        if TWISTS[i] == 1:
            y, z = z, -y
        elif TWISTS[i] == -1:
            y, z = -z, y
    return x, y, z, p


def angles(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    sine = np.hypot(x[2], y[2])
    return np.stack([np.arctan2(z[1], z[0]), np.arctan2(sine, z[2]), np.arctan2(y[2], -x[2])])


class Cost:
    """The published cost, 1 per mm and 100 per radian of ZYZ angles, of postures (7, n)."""

    def __init__(self, pose: np.ndarray) -> None:
        self.point = pose[:3, 3:4]
        self.angles = angles(*pose[:3, :3].T[:, :, None])

    def __call__(self, q: np.ndarray) -> np.ndarray:
        x, y, z, p = forward(q)
        d = angles(x, y, z) - self.angles
        d -= 2 * np.pi * np.round(d / (2 * np.pi))
        way = p - self.point
        return 1000 * np.sqrt((way * way).sum(0)) + 100 * np.sqrt((d * d).sum(0))


def evolve(pose: np.ndarray, seed: int, population: int = 100, generations: int = 200):
    """Return the best posture and its cost after the published number of generations."""
    rng = np.random.default_rng(seed)
    cost = Cost(pose)
    limits = LIMITS[:, None]
    shape = (7, population)
    genes = rng.uniform(-limits, limits, shape)
    costs = cost(genes)
    column = np.arange(population)
    row = np.arange(7)[:, None]
    for _ in range(generations):
        best = genes[:, [int(np.argmin(costs))]]
        a = rng.integers(0, population - 1, population)
        a += a >= column
        b = rng.integers(0, population - 2, population)
        low, high = np.minimum(a, column), np.maximum(a, column)
        b += b >= low
        b += b >= high
        mutant = best + 0.5 * (genes[:, a] - genes[:, b])
        rate = 0.75 * (0.5 + rng.random(shape))
        taken = (rng.random(shape) < rate) | (row == rng.integers(0, 7, population))
        trial = np.where(taken, mutant, genes)
        trial[np.abs(trial) > limits] = 0.0
        trial_costs = cost(trial)
        better = trial_costs < costs
        genes = np.where(better, trial, genes)
        costs = np.where(better, trial_costs, costs)
    best = int(np.argmin(costs))
    return genes[:, best], float(costs[best])
