"""Torques of the tomato arm: (1) to (4) as printed and corrected, and the servos' margins."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

from ...arms import HD_6001HB, HS_311, Load, Servo, holding_torques
from .._output import write_csv

GRAVITY = 9.80665


class Stretched(NamedTuple):
    """Lengths (m), weights (N) and torques (N m) of the arm stretched out level."""

    l1: float
    l2: float
    link1: float
    link2: float
    motor: float
    payload: float
    shoulder: float
    elbow: float


class TorqueRow(NamedTuple):
    """A case of the torque table.

    Attributes
    ----------
    case : str
        In words.
    shoulder, elbow : float, N m
        Holding torques.
    shoulder_factor, elbow_factor : float
        Servo torque over holding torque.
    enough : bool
        Both factors reach 1.7.
    shoulder_printed, elbow_printed : float, N m
        (3) and (4) as printed; NaN in poses that they are not for.
    """

    case: str
    shoulder: float
    elbow: float
    shoulder_factor: float
    elbow_factor: float
    enough: bool
    shoulder_printed: float
    elbow_printed: float


def stretched(l1: float = 0.16, l2: float = 0.16, load: Load | None = None) -> Stretched:
    """Return what pulls at the level arm and what its joints hold."""
    load = Load() if load is None else load
    held = holding_torques(l1, l2, load)
    masses = (load.link1, load.link2, load.motor, load.payload)
    link1, link2, motor, payload = (GRAVITY * mass for mass in masses)
    return Stretched(l1, l2, link1, link2, motor, payload, held.shoulder, held.elbow)


def printed_torques(l1: float, l2: float, load: Load) -> tuple[float, float]:
    """Return M1 by (3) and M2 by (4) as printed: only link 1 may balance off its middle."""
    a, _ = load.centres(l1, l2)
    g1, g2 = GRAVITY * load.link1, GRAVITY * load.link2
    gm, go = GRAVITY * load.motor, GRAVITY * load.payload
    return a * g1 + l1 * gm + (l1 + l2 / 2) * g2 + (l1 + l2) * go, l2 / 2 * g2 + l2 * go


def torque_rows() -> list[TorqueRow]:
    """Return the torque table."""
    cases: dict[str, tuple[float, Load, float]] = {
        "l = 0.16 m, links 32 g": (0.16, Load(), 0.0),
        "l = 0.20 m, links 40 g": (0.20, Load(link1=0.04, link2=0.04), 0.0),
        "l = 0.16 m, shoulder up 45 degrees": (0.16, Load(), math.pi / 4),
        "l = 0.16 m, without payload": (0.16, Load(payload=0.0), 0.0),
        "l = 0.16 m, a1 = 0.05 m": (0.16, Load(a1=0.05), 0.0),
        "l = 0.16 m, a2 = 0.05 m": (0.16, Load(a2=0.05), 0.0),
        "l = 0.16 m, a1 = a2 = 0.05 m": (0.16, Load(a1=0.05, a2=0.05), 0.0),
        "l = 0.16 m, a1 = -0.03 m (counterweight)": (0.16, Load(a1=-0.03), 0.0),
    }
    rows = []
    for name, (link, load, phi1) in cases.items():
        held = holding_torques(link, link, load, phi1=phi1, gravity=GRAVITY)
        level = printed_torques(link, link, load) if phi1 == 0 else (math.nan, math.nan)
        rows.append(TorqueRow(name, *held, *level))
    return rows


def torque_report() -> list[str]:
    """Return the torque table in Markdown."""
    lines = [
        "# Torques: (1) to (4), and what the servos have to spare",
        "",
        f"Shoulder and elbow {HD_6001HB.name} ({HD_6001HB.torque} N m; {HD_6001HB.source}). "
        "Lengths and masses are our choice; enough is a factor of 1.7. a1 and a2 are the links' "
        'centres of mass from their own joints; "printed" is (3) and (4), which know a1 alone.',
        "",
        "| case | shoulder, N m | printed | elbow, N m | printed | factor, shoulder "
        "| factor, elbow | enough |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in torque_rows():
        printed = [
            "" if math.isnan(x) else f"{x:.3f}" for x in (row.shoulder_printed, row.elbow_printed)
        ]
        lines.append(
            f"| {row.case} | {row.shoulder:.3f} | {printed[0]} | {row.elbow:.3f} | {printed[1]} "
            f"| {row.shoulder_factor:.2f} | {row.elbow_factor:.2f} "
            f"| {'yes' if row.enough else 'no'} |"
        )
    return lines


def write_torques(directory: Path) -> list[Path]:
    """Write the torque table and the servos; return the files."""
    servo_rows = [_servo_row("shoulder, elbow", HD_6001HB), _servo_row("pan", HS_311)]
    header = ["case", "shoulder_nm", "elbow_nm", "shoulder_factor", "elbow_factor", "enough"]
    header += ["shoulder_printed_nm", "elbow_printed_nm"]
    lines = [
        (
            row.case,
            *(f"{x:.4f}" for x in row[1:5]),
            row.enough,
            *("" if math.isnan(x) else f"{x:.4f}" for x in row[6:]),
        )
        for row in torque_rows()
    ]
    return [
        write_csv(directory / "torques.csv", header, lines),
        write_csv(
            directory / "servos.csv",
            ["joints", "servo", "torque_nm", "mass_kg", "speed_rad_s", "source"],
            servo_rows,
        ),
    ]


def _servo_row(joints: str, servo: Servo) -> tuple[object, ...]:
    return joints, servo.name, servo.torque, servo.mass, round(servo.speed, 3), servo.source
