"""Joint values of the kinds that people set: structured, at limits, straight, and random ones."""

from __future__ import annotations

import numpy as np

from .chain import Arm, Array

KINDS = ("random", "structured", "at limits", "straight", "next to limits")
"""What `draw` knows."""

FREE = np.pi
"""How far a turning joint without limits, or with limits far out, is drawn to."""


def bounds(arm: Arm, slide: float | None = None) -> tuple[Array, Array]:
    """Return what values are drawn from: the limits, or less where those are far out.

    Parameters
    ----------
    arm : Arm
        The arm.
    slide : float, optional
        How far slides are drawn whose limits are more than 1e4 of it, m; default a few times
        the arm's typical length.
    """
    slide = 3 * arm.scale if slide is None else slide
    most = np.where(arm.turns, FREE, slide)
    low, high = arm.lower.copy(), arm.upper.copy()
    wide = ~(high - low < np.where(arm.turns, 2000.0, 1e5 * slide))
    # Limits far out mean "none": what people want is near zero, or near the end that is there.
    centre = np.clip(0.0, low, high)
    low = np.where(wide, np.maximum(low, centre - most), low)
    high = np.where(wide, np.minimum(high, centre + most), high)
    return low, high


def draw(arm: Arm, kind: str, count: int, rng: np.random.Generator) -> Array:
    """Draw joint values of one kind, shape (count, dof), rad or m, inside the limits."""
    low, high = bounds(arm)
    q = low + (high - low) * rng.random((count, arm.dof))
    if kind == "structured":
        q = _structured(arm, q, low, high, rng)
    elif kind == "at limits":
        side = rng.random(q.shape)
        q = np.where(side < 0.4, low, np.where(side < 0.8, high, q))
    elif kind == "straight":
        # All of the joints, all but a few, or the last three stretched out.
        zero = np.broadcast_to(np.clip(0.0, low, high), q.shape)
        share = rng.choice([0.0, 0.3, 0.6], (count, 1))
        straight = np.where(rng.random(q.shape) < share, q, zero)
        last = np.arange(arm.dof) >= arm.dof - 3
        wrist = rng.random((count, 1)) < 0.3
        q = np.where(wrist & ~last, q, straight)
        bent = wrist & (np.arange(arm.dof) != max(arm.dof - 2, 0))
        q = np.where(bent, low + (high - low) * rng.random(q.shape), q)
    elif kind == "next to limits":
        inwards = (high - low) * 10.0 ** rng.uniform(-15, -3, q.shape)
        side = rng.random(q.shape)
        near = np.where(side < 0.5, low + inwards, high - inwards)
        q = np.where(rng.random(q.shape) < 0.7, near, q)
    elif kind != "random":
        raise ValueError(f"no kind of posture is called {kind!r}; known: {', '.join(KINDS)}")
    return np.clip(q, arm.lower, arm.upper)


def _structured(arm: Arm, q: Array, low: Array, high: Array, rng: np.random.Generator) -> Array:
    quarter, half = np.full(q.shape, np.pi / 4), np.full(q.shape, np.pi / 2)
    choices = np.stack(
        [
            np.zeros(q.shape),
            half,
            -half,
            quarter,
            np.broadcast_to(low, q.shape),
            np.broadcast_to(high, q.shape),
            np.broadcast_to((low + high) / 2, q.shape),
            q,
        ]
    )
    pick = rng.integers(len(choices), size=q.shape)
    chosen = np.take_along_axis(choices, pick[None], axis=0)[0]
    # Right angles mean nothing to a slide, and what lies outside the limits is no posture.
    angles = (pick >= 1) & (pick <= 3) & ~arm.turns
    return np.where(angles | (chosen < low) | (chosen > high), q, chosen)
