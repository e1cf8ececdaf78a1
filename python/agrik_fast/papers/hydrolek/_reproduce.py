"""All files of the HydroLek paper."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..._checks import FloatArray
from ...robot import Robot
from ...solvers import IkPid, StateSpace
from ...tuning.goals import joint_uniform, joint_uniform_q
from .._output import write_csv, write_text
from . import _figures
from ._published import PLANAR_DEG
from ._studies import write_studies
from ._tables import (
    GOALS,
    SIDES,
    TABLE_2_COLUMNS,
    comparison,
    displaced_goal,
    error_trace,
    planar_arm,
    planar_claim,
    singular_start,
    success_counts,
    units,
)


def reproduce(directory: Path, report: Callable[[str], None] | None = None) -> list[Path]:
    """Write the paper's tables (CSV) and figures (PNG, SVG) and return the files.

    Parameters
    ----------
    directory : path
        An existing folder, or one to be made.
    report : callable, optional
        Told in a few words what is being made.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    AgrikError
        Matplotlib is missing.
    """
    say = report or (lambda _: None)
    directory.mkdir(parents=True, exist_ok=True)
    robot = Robot.load("hydrolek")
    goals = joint_uniform(robot, GOALS, 1)
    files = []
    header = TABLE_2_COLUMNS
    for start in SIDES:
        say(f"Table II, start {start}")
        rows = comparison(robot, goals, start)
        files.append(write_csv(directory / f"table2_{start}.csv", header, rows))
    say("success counts")
    rows = success_counts(robot)
    head = ["method", "start", "published", "J1", "J11", "J12", "V", "J1_lost_at_edge"]
    files.append(write_csv(directory / "success.csv", head, rows))
    rows = units(robot)
    head = ["units", "start", "kp_0.0847", "kp_0.02", "tuned"]
    files.append(write_csv(directory / "units.csv", head, rows))
    files += _figures.units(directory, rows)
    say("singular start")
    rows = singular_start()
    head = ["solver", "start", "status", "iterations", "error_m", "q_deg", "reached_of_1000"]
    files.append(write_csv(directory / "singular_start.csv", head, rows))
    say("figures 4 to 7")
    goal = displaced_goal(robot, "zero")
    hot = IkPid.load("hydrolek_pid_published_hot", as_tuned=True)
    traces = {
        f"Kp = {kp}": error_trace(robot, replace(hot, kp=kp), goal, "zero", 60, 1e-4)
        for kp in (0.0848, 0.0847, 0.02)
    }
    files += _figures.error_traces(directory, "figure4", {"IK-PID, Ki = Kd = 0": traces}, "sweeps")
    sets = {"trial and error": "hydrolek_trial_published", "optimised": "hydrolek_full90_pso"}
    panels = {
        title: {
            title: error_trace(robot, StateSpace.load(name, as_tuned=True), goal, "zero", 400, 1e-4)
        }
        for title, name in sets.items()
    }
    files += _figures.error_traces(directory, "figure5", panels, "iterations")
    solver = StateSpace.load("hydrolek_full90_pso", as_tuned=True)
    answer = robot.ik(goals, solver=solver, position_tolerance=1e-3)
    turn = robot.frames["paper"][:3, :3]
    files += _figures.workspace(directory, goals @ turn.T, answer.success)
    arm = planar_arm()
    found = arm.ik(
        np.array([5.0, 0.0, 0.0]),
        solver=StateSpace.load("planar3_claim", as_tuned=True),
        position_tolerance=0.02,
    )
    cloud = arm.fk(joint_uniform_q(arm, 4000, 3))[:, :2, 3]
    files += _figures.planar(directory, cloud, arm.fk_links(found.q)[:, :2, 3])
    say("edge, singular postures, poses, stability, further robots")
    files += write_studies(directory, robot)
    files.append(_summary(directory, found.q))
    return files


def _summary(directory: Path, planar_q: FloatArray) -> Path:
    angles = ", ".join(f"{angle:.1f}" for angle in np.rad2deg(planar_q))
    published = ", ".join(map(str, PLANAR_DEG))
    lines = [
        "# What is in the tables",
        "",
        "table2_*.csv: Table II on goals drawn uniformly in the joint limits; one thread.",
        "success.csv: goals reached of 1,000; units.csv: what units the gains can be in.",
        "lost.csv: where goals are lost; near_singular.csv: starts beside singular postures;",
        "pose.csv: poses by what a radian counts as; stability.csv: the state space about its",
        "goals; robots.csv: gains for further robots.",
        "",
        "# Planar arm",
        "",
        f"Planar arm at (5, 0): ({angles}) degrees; published ({published}) degrees,",
        f"which miss the goal by {planar_claim():.4f} link units.",
    ]
    return write_text(directory / "report.md", lines)
