"""Problem P1 of the strawberry paper as printed, step by step put right.

P1 looks for the s10 at which the derivative of the energy, (24) and (25), vanishes, under
the conditions (30) to (36), with the lower of (27) and (28) as the derivative of theta.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..._checks import FloatArray
from ...arms import StrawberryArm
from .._output import write_csv
from ._published import published, targets

_POINTS = 4001


@dataclass(frozen=True, slots=True, kw_only=True)
class Formulas:
    """Which of P1's formulas are taken as printed.

    Attributes
    ----------
    l2_in_26 : bool
        (26) with l2, where l1 belongs.
    sign_of_24 : bool
        (24) as the derivative of PE_f - PE_in, which table 3 does not use.
    lowest_slope : bool
        The lower of (27) and (28) as the derivative of theta; without it theta stays, as
        remark 2 chooses it.
    """

    l2_in_26: bool = True
    sign_of_24: bool = True
    lowest_slope: bool = True


CORRECTED = Formulas(l2_in_26=False, sign_of_24=False, lowest_slope=False)


@dataclass(frozen=True, slots=True)
class Derivatives:
    """P1's functions of s10 for one target.

    Attributes
    ----------
    s10, beta : ndarray, shape (n,), m and rad
        The set (12) of s10, and beta by (13).
    slope27, slope28 : ndarray, shape (n,), complex
        (27) and (28): imaginary where the arc functions have no real value.
    total : ndarray, shape (n,), complex, J/m
        (23): the sum of (24) and (25).
    friction : ndarray, shape (n,), complex, J/m
        (25), which (30) wants to vanish too, over the friction force.
    conditions : ndarray, shape (n, 6), m
        Left sides of (31) to (36): negative where they hold.
    """

    s10: FloatArray
    beta: FloatArray
    slope27: NDArray[np.complex128]
    slope28: NDArray[np.complex128]
    total: NDArray[np.complex128]
    friction: NDArray[np.complex128]
    conditions: FloatArray


def derivatives(
    arm: StrawberryArm, target: FloatArray, formulas: Formulas, theta_step: float = 0.01
) -> Derivatives | None:
    """Return P1's functions over the set of s10, or None where that is empty.

    Theta is what remark 2 chooses, 0 with a step of 0.01 rad, as in table 3.
    """
    interval = arm.s10_set(target)
    if interval is None:
        return None
    p = arm.parameters
    l1, l2, l3, mu, m2, m3, g = (
        float(np.asarray(p[name]))
        for name in ("l1", "l2", "l3", "friction", "mass2", "mass3", "gravity")
    )
    d, lower = np.asarray(p["d"]), arm.lower
    s10 = np.linspace(*interval, _POINTS)
    beta = np.arcsin(np.clip((target[1] - s10 - l1 + d[1]) / l3, -1.0, 1.0))
    cb, sb = np.cos(beta), np.sin(beta)
    theta = theta_step
    ct, st = np.cos(theta), np.sin(theta)
    r = l2 + l3 * cb
    h1 = (target[0] - lower[1] - d[0]) / -r + 0j
    h2 = (target[2] + lower[2] - d[2]) / -r + 0j
    # d/dbeta of 1/r is l3 sin(beta) / r^2; the arc functions bring the rest.
    slope27 = h1 * l3 * sb / r / np.sqrt(1 - h1**2)
    slope28 = -h2 * l3 * sb / r / np.sqrt(1 - h2**2)
    # As a program does that compares complex numbers: by their size.
    lowest = np.where(np.abs(slope27) < np.abs(slope28), slope27, slope28)
    slope = lowest if formulas.lowest_slope else 0 * lowest
    straight = target[1] - s10 + d[1] - (l2 if formulas.l2_in_26 else l1)
    by_s10 = -1 / np.sqrt(l3**2 - straight**2 + 0j)
    printed = (
        -m2 * (l2 / 2 + l3 * cb) * g * st * slope * by_s10
        - m3 * l3 * g * cb * st / 2 * slope * by_s10
        + (-m2 - m3 / 2) * l3 * g * sb * ct * by_s10
    )
    potential = printed if formulas.sign_of_24 else -printed
    friction = r * (ct + st) * slope * by_s10 + l3 * sb * (ct - st) * by_s10 + 1
    conditions = np.stack(
        [
            target[1] - s10 - l2 + d[1] - l3,
            -target[1] + s10 + l2 - d[1] - l3,
            -target[0] + lower[1] + d[0] - r,
            target[0] - lower[1] - d[0] - r,
            target[2] + lower[2] - d[2] - r,
            -target[2] - lower[2] + d[2] - r,
        ],
        axis=-1,
    )
    return Derivatives(s10, beta, slope27, slope28, potential + mu * friction, friction, conditions)


@dataclass(frozen=True, slots=True)
class Row:
    """A reading of P1 over the 20 targets of table 3.

    Attributes
    ----------
    reading : str
        In words.
    solved : int
        Targets for which the reading gives an s10.
    reached : int
        Targets that steps 3 to 7 then reach.
    above_ssas : tuple of 2 float, mJ
        Least and greatest energy above the published SSAS; NaN where nothing is reached.
    above_ours : float, mJ
        Greatest difference from our SSAS; NaN where nothing is reached.
    """

    reading: str
    solved: int
    reached: int
    above_ssas: tuple[float, float]
    above_ours: float


READINGS = {
    "as printed, with (30)-(36)": (Formulas(), True),
    "as printed, without (30)-(36)": (Formulas(), False),
    "(26) with l1": (Formulas(l2_in_26=False), False),
    "(26) with l1, sign of (24)": (Formulas(l2_in_26=False, sign_of_24=False), False),
    "the same, theta stays: corrected": (CORRECTED, False),
}
"""Readings of P1, each with whether (30) to (36) are conditions."""


def conditions_hold(found: Derivatives, tolerance: float = 1e-6) -> NDArray[np.bool_]:
    """Say at which s10 the conditions (30) to (36) hold, shape (n,)."""
    return (found.conditions < 0).all(axis=1) & (np.abs(found.friction) < tolerance)


def problem1(arm: StrawberryArm | None = None) -> list[Row]:
    """Return every reading of `READINGS` over the targets of table 3."""
    arm = StrawberryArm() if arm is None else arm
    points, paper = targets(), published()
    ours = 1000 * arm.solve(points, "ssas").energy
    rows = []
    for name, (formulas, conditions) in READINGS.items():
        apart, off = [], []
        solved = 0
        for k, target in enumerate(points):
            found = derivatives(arm, target, formulas)
            if found is None:
                continue
            size = np.abs(found.total)
            if conditions:
                size = np.where(conditions_hold(found), size, np.inf)
            if not np.isfinite(size).any():
                continue
            solved += 1
            i = int(np.nanargmin(size))
            low, high = found.s10[0], found.s10[-1]
            ended = arm.solve(target, "as", s10_share=(found.s10[i] - low) / (high - low))
            if ended.success:
                energy = 1000 * float(ended.energy)
                apart.append(energy - paper[k]["J_SSAS"])
                off.append(abs(energy - float(ours[k])))
        span = (min(apart), max(apart)) if apart else (np.nan, np.nan)
        rows.append(Row(name, solved, len(apart), span, max(off, default=np.nan)))
    return rows


def write_problem1(directory: Path, rows: list[Row]) -> Path:
    """Write the readings of P1."""
    header = ["reading", "solved", "reached", "above_published_ssas_least_mJ"]
    header += ["above_published_ssas_greatest_mJ", "off_our_ssas_mJ"]
    lines = [
        (
            row.reading,
            row.solved,
            row.reached,
            *("" if np.isnan(x) else f"{x:.3f}" for x in (*row.above_ssas, row.above_ours)),
        )
        for row in rows
    ]
    return write_csv(directory / "problem1.csv", header, lines)
