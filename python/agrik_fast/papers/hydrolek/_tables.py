"""Tables of the HydroLek paper, its success counts and its planar arm, computed anew."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from ..._checks import FloatArray, matrix
from ...result import Status
from ...robot import Robot
from ...solvers import (
    Broyden,
    ClosedPseudoInverse,
    CyclicCoordinateDescent,
    DampedLeastSquares,
    Feedback,
    IkPid,
    JacobianSolver,
    LevenbergMarquardt,
    Plain,
    PseudoInverse,
    Solver,
    StateSpace,
    StaticGain,
    Transpose,
)
from ...tuning.goals import joint_uniform, volume_uniform
from .._output import seconds_in_turns
from ._published import DISPLACEMENT_M, PLANAR_DEG, SUCCESS, TABLE_2_MS, TOLERANCES_M
from ._workspace import Edge

CAP = 1000
GOALS = 1000
SIDES = ("zero", "middle")
TABLE_2_COLUMNS = (
    "method",
    "tolerance_m",
    "reached",
    "kept",
    "iterations",
    "fk",
    "fk_and_jacobian",
    "us",
    "ratio_to_closed_form",
    "ratio_to_svd",
    "published_ms",
    "published_ratio",
)
# Joint values that a planar nudge of the start moves by, rad.
NUDGE = 1e-6 * np.array([1.0, -2.0, 1.0])


def planar_arm() -> Robot:
    """Return the paper's arm of three links of 2 m (Table III)."""
    rows = np.array([[2.0, 0.0, 0.0, 0.0]] * 3)
    limit = np.deg2rad(60)
    return Robot.from_dh(
        rows, limits=[(-limit, limit)] * 3, joint_types=["revolute"] * 3, name="planar3"
    )


def static_gain(name: str) -> StaticGain:
    """Return the gain that a bundled state space settles to."""
    source = StateSpace.load(name, as_tuned=True)
    return StaticGain(
        K=matrix("K", source.static_gain()),
        length_unit_m=source.length_unit_m,
        angle_unit_rad=source.angle_unit_rad,
        frame=source.frame,
        robot=source.robot,
    )


def methods() -> dict[str, tuple[JacobianSolver | Feedback, str]]:
    """Return the compared solvers with the line of Table II that each stands beside."""
    gain = static_gain("hydrolek_k15_cma")
    return {
        "pseudo-inverse, closed form": (ClosedPseudoInverse(), "pseudo-inverse"),
        "pseudo-inverse, SVD": (PseudoInverse(cutoff=1e-9), "pseudo-inverse"),
        "transpose": (Transpose(), "transpose"),
        "damped, 200 mm": (DampedLeastSquares(damping=0.2), "damped"),
        "IK-PID, published": (IkPid.load("hydrolek_pid_published_tuned", as_tuned=True), "IK-PID"),
        "state space, 90 (PSO)": (
            StateSpace.load("hydrolek_full90_pso", as_tuned=True),
            "state space",
        ),
        "state space, 15 (CMA-ES)": (
            StateSpace.load("hydrolek_k15_cma", as_tuned=True),
            "state space",
        ),
        "static gain, 15": (gain, "state space"),
        "Broyden from static gain": (Broyden.from_gain(gain), ""),
        "coordinate descent": (CyclicCoordinateDescent(), ""),
        "LM": (LevenbergMarquardt(), ""),
    }


def plain(solver: JacobianSolver | Feedback, start: str) -> Solver:
    """Return the solver as the paper runs it: one attempt, full steps, saturation."""
    if isinstance(solver, LevenbergMarquardt):
        # Its active set is what makes it work at limits; one attempt all the same.
        return replace(solver, max_iterations=CAP, max_restarts=0)
    return Plain(solver=solver, start=start)


def _start(robot: Robot, start: str) -> FloatArray:
    middle = 0.5 * (robot.lower + robot.upper)
    return middle if start == "middle" else np.clip(np.zeros(robot.dof), robot.lower, robot.upper)


def comparison(robot: Robot, goals: FloatArray, start: str) -> list[list[object]]:
    """Return Table II anew: one row a method and tolerance.

    Columns: method, tolerance (m), goals reached, goals left after those that some method
    misses at some tolerance are removed, mean iterations on these, kinematics evaluations
    (FK and FK with Jacobian), us of processor time a solve on one thread, its ratio to the
    closed-form pseudo-inverse and to the one by SVD, and the published ms and ratio.
    """
    q0 = _start(robot, start)
    runs = {}
    common = np.ones(len(goals), dtype=bool)
    for name, (solver, _) in methods().items():
        for tolerance in TOLERANCES_M:
            answer = robot.ik(
                goals, solver=plain(solver, start), q0=q0, position_tolerance=tolerance
            )
            runs[name, tolerance] = answer
            common &= answer.success
    kept = goals[common]
    works = {
        (name, tolerance): partial(
            robot.ik,
            kept,
            solver=plain(solver, start),
            q0=q0,
            position_tolerance=tolerance,
            threads=1,
        )
        for name, (solver, _) in methods().items()
        for tolerance in TOLERANCES_M
    }
    times = {key: 1e6 * t / max(len(kept), 1) for key, t in seconds_in_turns(works).items()}
    rows: list[list[object]] = []
    for name, (solver, line) in methods().items():
        for i, tolerance in enumerate(TOLERANCES_M):
            answer = runs[name, tolerance]
            steps = float(answer.iterations[common].mean())
            forward, jacobians = _evaluations(solver, robot.dof, steps)
            time = times[name, tolerance]
            published = TABLE_2_MS[line][i] if line else None
            reference = TABLE_2_MS["pseudo-inverse"][i]
            ratio = None if published is None or reference is None else published / reference
            rows.append(
                [
                    name,
                    tolerance,
                    int(answer.success.sum()),
                    len(kept),
                    round(steps, 2),
                    round(forward, 1),
                    round(jacobians, 1),
                    round(time, 3),
                    round(time / times["pseudo-inverse, closed form", tolerance], 2),
                    round(time / times["pseudo-inverse, SVD", tolerance], 2),
                    published,
                    None if ratio is None else round(ratio, 3),
                ]
            )
    return rows


def _evaluations(solver: Solver, dof: int, steps: float) -> tuple[float, float]:
    """Return passes of forward kinematics alone, and of it with the Jacobian."""
    if isinstance(solver, IkPid):
        return 2 * dof * steps + 1, 0.0
    if isinstance(solver, StateSpace | StaticGain | Broyden | CyclicCoordinateDescent):
        return steps + 1, 0.0
    return 0.0, steps + 1


def success_counts(robot: Robot) -> list[list[object]]:
    """Return goals reached of 1,000 at 1 mm: published, on sets J (three seeds) and V.

    The last column: how many of those lost of the first set J are at the workspace's edge.
    """
    solvers: Mapping[str, JacobianSolver | Feedback] = {
        "IK-PID, Kp 0.02": IkPid.load("hydrolek_pid_published_kp", as_tuned=True),
        "IK-PID, tuned": IkPid.load("hydrolek_pid_published_tuned", as_tuned=True),
        "state space, trial": StateSpace.load("hydrolek_trial_published", as_tuned=True),
        "state space, optimised": StateSpace.load("hydrolek_full90_pso", as_tuned=True),
        "pseudo-inverse": ClosedPseudoInverse(),
        "transpose": Transpose(),
        "damped, 200 mm": DampedLeastSquares(damping=0.2),
    }
    sets = {f"J{seed}": joint_uniform(robot, GOALS, seed) for seed in (1, 11, 12)}
    sets["V"] = volume_uniform(robot, GOALS, 2)
    at_edge = Edge(robot).holds(sets["J1"])
    rows: list[list[object]] = []
    for name, solver in solvers.items():
        for start in SIDES:
            reached = [
                robot.ik(goals, solver=plain(solver, start), position_tolerance=1e-3).success
                for goals in sets.values()
            ]
            counts = [int(each.sum()) for each in reached]
            rows.append([name, start, SUCCESS[name], *counts, int((~reached[0] & at_edge).sum())])
    return rows


def units(robot: Robot) -> list[list[object]]:
    """Return goals reached by the IK-PID gains in three readings of their units."""
    goals = joint_uniform(robot, GOALS, 1)
    degree = float(np.pi / 180)
    readings = {"deg/mm": (1e-3, degree), "deg/cm": (1e-2, degree), "rad/m": (1.0, 1.0)}
    rows: list[list[object]] = []
    for reading, (length, angle) in readings.items():
        for start in SIDES:
            row: list[object] = [reading, start]
            for gains in ("hot", "kp", "tuned"):
                solver = replace(
                    IkPid.load(f"hydrolek_pid_published_{gains}", as_tuned=True),
                    length_unit_m=length,
                    angle_unit_rad=angle,
                )
                answer = robot.ik(goals, solver=plain(solver, start), position_tolerance=1e-3)
                row.append(int(answer.success.sum()))
            rows.append(row)
    return rows


def error_trace(
    robot: Robot,
    solver: JacobianSolver | Feedback,
    goal: FloatArray,
    start: str,
    steps: int,
    tolerance: float,
) -> FloatArray:
    """Return the error after 0, 1, 2, ... steps of one solve, m; ends where it ends."""
    q0 = _start(robot, start)
    errors = [float(np.linalg.norm(robot.fk(q0)[:3, 3] - goal))]
    for cap in range(1, steps + 1):
        answer = robot.ik(
            goal,
            solver=Plain(solver=solver, start=start, max_iterations=cap),
            q0=q0,
            position_tolerance=tolerance,
        )
        errors.append(float(answer.position_error))
        if answer.status != Status.NOT_FOUND:
            break
    return np.array(errors)


def displaced_goal(robot: Robot, start: str) -> FloatArray:
    """Return the goal (-10, 50, -20) cm away from the start in the paper frame, m."""
    turn = robot.frames["paper"][:3, :3]
    point: FloatArray = robot.fk(_start(robot, start))[:3, 3] + np.array(DISPLACEMENT_M) @ turn
    return point


def singular_start() -> list[list[object]]:
    """Return what becomes of the stretched planar arm with its goal on its own line.

    Columns: solver, start, status, iterations, error (m), joint values (degrees), goals
    reached of 1,000 reachable ones from the stretched pose (tolerance 0.01 m).
    """
    arm = planar_arm()
    goal = np.array([5.0, 0.0, 0.0])
    five = IkPid(kp=5.0, ki=0.0, kd=0.0, length_unit_m=1.0)
    solvers: dict[str, JacobianSolver | Feedback] = {
        "transpose": Transpose(),
        "pseudo-inverse": PseudoInverse(cutoff=1e-9),
        "damped, 1 m": DampedLeastSquares(damping=1.0),
        "IK-PID, 5 degrees a unit": five,
        "state space, claim": StateSpace.load("planar3_claim", as_tuned=True),
        "state space, set": StateSpace.load("planar3_set", as_tuned=True),
        "state space, full": StateSpace.load("planar3_set_full", as_tuned=True),
    }
    others = joint_uniform(arm, GOALS, 1)
    rows: list[list[object]] = []
    for name, solver in solvers.items():
        many = arm.ik(others, solver=plain(solver, "zero"), position_tolerance=1e-2)
        for start, q0 in (("stretched", np.zeros(3)), ("nudged", NUDGE)):
            answer = arm.ik(goal, solver=plain(solver, "zero"), q0=q0, position_tolerance=1e-6)
            angles = " ".join(f"{angle:.3f}" for angle in np.rad2deg(answer.q))
            rows.append(
                [
                    name,
                    start,
                    Status(int(answer.status)).name.lower(),
                    int(answer.iterations),
                    float(answer.position_error),
                    angles,
                    int(many.success.sum()) if start == "stretched" else None,
                ]
            )
    return rows


def planar_claim() -> float:
    """Return the error of the published joint angles at (5, 0), m."""
    point = planar_arm().fk(np.deg2rad(PLANAR_DEG))[:3, 3]
    return float(np.linalg.norm(point - np.array([5.0, 0.0, 0.0])))
