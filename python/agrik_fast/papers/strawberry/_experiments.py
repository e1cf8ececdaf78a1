"""The 24 experiments of section 5.3: their list and the model of their times, one for all uses."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..._checks import FloatArray
from ...arms import Command, StrawberryArm
from ._published import SPHERE_CENTRE, Column

TARGETS = np.array(
    [
        [0.426, 0.345, -0.3316],
        [0.450, 0.285, -0.3686],
        [0.580, 0.310, -0.3779],
        [0.520, 0.350, -0.2986],
        [0.565, 0.420, -0.3401],
        [0.535, 0.450, -0.3506],
        [0.450, 0.400, -0.3147],
        [0.410, 0.410, -0.3853],
    ]
)
"""Targets, m, two in each quadrant. The third and the fifth are published; the paper does not name
the other six, which are our choice from its table 3."""

METHODS: tuple[Column, ...] = ("ncos", "ssas", "as")
"""Methods, three runs a target."""

H_EXTRA = 0.03
"""How far above its end the arm waits, m; assumed."""

SLIDE_SPEED = 0.2
"""Speed of the slides, m/s, at which the published mean time comes out; the motors give 0.37."""

RAMP_TIME = 0.25
"""From standing to full speed, s; assumed."""

SERVO_SPEED = math.radians(60) / 0.21
"""HS-422 without load at 4.8 V, rad/s; data sheet value from memory."""

GRIPPER_TIME = 0.3
"""Opening or closing, s; assumed."""

COMMAND_TIME = 0.05
"""From the end of a motion to the beginning of the next step, s; assumed."""


@dataclass(frozen=True, slots=True)
class Experiment:
    """One run: out by the command sequence, and the time it takes by the model.

    Attributes
    ----------
    number : int
        Number of the run, from 1.
    target : tuple of float, m
        Where to.
    quadrant : int
        Of the plant, from 1.
    column : str
        ncos, ssas or as.
    q : ndarray, shape (5,), m and rad
        Joint values of the method.
    steps : tuple of Command
        The command sequence.
    seconds : float
        By the model.
    """

    number: int
    target: tuple[float, float, float]
    quadrant: int
    column: Column
    q: FloatArray
    steps: tuple[Command, ...]
    seconds: float


def quadrant(target: FloatArray) -> int:
    """Return the quadrant of the plant that a target is in, from 1, as table 3 counts them."""
    right, back = target[0] > SPHERE_CENTRE[0], target[1] > SPHERE_CENTRE[1]
    return {(False, False): 1, (True, False): 2, (True, True): 3, (False, True): 4}[
        bool(right), bool(back)
    ]


def slide_time(way: float, speed: float) -> float:
    """Return how long a slide takes for a way (m) by a trapezoid of speed, s."""
    ramp = speed * RAMP_TIME
    if abs(way) < ramp:
        return 2 * math.sqrt(abs(way) * RAMP_TIME / speed)
    return abs(way) / speed + RAMP_TIME


def execution_time(
    steps: Sequence[Command], start: FloatArray, slide_speed: float = SLIDE_SPEED
) -> float:
    """Return how long a command sequence takes, s, one step after the other.

    Parameters
    ----------
    steps : sequence of Command
        The sequence.
    start : ndarray, shape (5,), m and rad
        Where it begins.
    slide_speed : float, m/s
        Full speed of the slides.
    """
    at = dict(zip(("s10", "s21", "s32", "theta", "beta"), start.tolist(), strict=True))
    seconds = 0.0
    for step in steps:
        if step.axis == "gripper":
            seconds += GRIPPER_TIME
            continue
        way = step.target - at.get(step.axis, 0.0)
        at[step.axis] = step.target
        if way == 0.0:
            continue
        slide = step.axis.startswith("s")
        seconds += slide_time(way, slide_speed) if slide else abs(way) / SERVO_SPEED
        seconds += COMMAND_TIME
    return seconds


def experiments(slide_speed: float = SLIDE_SPEED) -> list[Experiment]:
    """Return the 24 experiments: 2 targets in each of 4 quadrants by 3 methods, from home."""
    arm = StrawberryArm()

    def runs() -> Iterator[Experiment]:
        number = 0
        for target in TARGETS:
            for column in METHODS:
                number += 1
                q = np.asarray(arm.solve(target, column).q)
                steps = tuple(arm.commands(q, h_extra=H_EXTRA))
                seconds = execution_time(steps, arm.reset_pose, slide_speed)
                x, y, z = target.tolist()
                yield Experiment(number, (x, y, z), quadrant(target), column, q, steps, seconds)

    return list(runs())
