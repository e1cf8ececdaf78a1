"""``agrik-fast plan``: a path that is proven free, as a trajectory in a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .. import harvest, motion
from .._checks import FloatArray
from ..collision import Scene
from ..errors import ArgumentError
from ..jobs import RobotChoice
from ..robot import Robot
from ..rotations import pose
from ._options import numbers
from ._solve import parse_solver


def plan(
    robot: RobotChoice,
    scene: Path | None,
    start: str | None,
    target: str,
    *,
    clear: float,
    seed: int,
    solver: str | None = None,
) -> tuple[Robot, Scene, motion.Plan]:
    """Plan from a posture to a target: a name of the scene, a point, a pose, or joint values.

    Raises
    ------
    AgrikError
        A faulty file or robot, or an option that is wrong.
    """
    arm = robot.load()
    around = Scene() if scene is None else Scene.load(scene)
    first = arm.home if start is None else np.array(numbers("--start", start, (arm.dof,)))
    settings = motion.Settings(clear=clear, seed=seed)
    if solver is not None and (target in around.targets or target.count(",") != 2):
        expected = "nothing but with a point x,y,z as --target: only for points is one asked"
        raise ArgumentError("--solver", solver, expected)
    if target in around.targets:
        return arm, around.aiming_at(target), _to_fruit(arm, around, first, target, settings)
    try:
        values = np.array(numbers("--target", target, tuple({3, 6, arm.dof})))
    except ArgumentError:
        names = ", ".join(around.targets) or "none"
        expected = (
            f"a target of the scene ({names}), x,y,z in metres, x,y,z,roll,pitch,yaw with "
            f"radians, or q= and {arm.dof} joint values with commas between them"
        )
        if not target.startswith("q="):
            raise ArgumentError("--target", repr(target), expected) from None
        values = np.array(numbers("--target", target[2:], (arm.dof,)))
        return arm, around, motion.plan(arm, first, values, around, settings=settings)
    if len(values) == 3:
        goals, reached = motion.goals_of(
            arm,
            values,
            task="position",
            seed=seed,
            solver="lm" if solver is None else parse_solver("--solver", solver),
        )
        found = motion.plan(arm, first, goals, around, settings=settings, prefer="near")
        return arm, around, found if len(goals) else found.because(reached=reached)
    if len(values) != 6:
        expected = f"q= before joint values, as in q={target}"
        raise ArgumentError("--target", repr(target), expected)
    wanted = pose(values[:3], rpy=values[3:])
    return arm, around, motion.plan(arm, first, wanted, around, settings=settings)


def _to_fruit(
    arm: Robot, scene: Scene, start: FloatArray, name: str, settings: motion.Settings
) -> motion.Plan:
    """Plan to a target of a scene: by the harvest's method where the arm is made for it."""
    try:
        found = harvest.plan(arm, scene, [name], path=True, start=start, path_settings=settings)
    except ArgumentError as error:
        if error.argument != "robot":
            raise
        point = np.array(scene.targets[name].point)
        goals, reached = motion.goals_of(arm, point, task="position", seed=settings.seed)
        aimed = scene.aiming_at(name)
        plan = motion.plan(arm, start, goals, aimed, settings=settings, prefer="near")
        return plan if len(goals) else plan.because(reached=reached)
    return found.paths[0]


def trajectory(
    arm: Robot, scene: Scene, found: motion.Plan, *, blend: float, clear: float
) -> motion.Trajectory:
    """Return a path with its times, its corners rounded as far as that is proven."""
    if len(found.path) == 1:
        raise ArgumentError("--target", "where the arm is already", "another posture")
    way = motion.rounded(arm, found, scene, blend=blend, clear=clear)
    return motion.time_law(arm, way)


def lines(found: motion.Plan) -> list[str]:
    """Return what is said of a plan."""
    if found.ok:
        return [
            f"OK: {found.how}, {len(found.path)} waypoints, {1e3 * found.certified:.1f} mm kept, "
            f"{found.checks} checks"
        ]
    said = [f"{found.status.name}: {found.checks} checks, {found.rounds} rounds"]
    if found.contact is not None:
        near = found.contact
        said.append(f"  {near.body} is {1e3 * near.distance:.1f} mm from {near.other}")
    if found.proof is not None:
        proof = found.proof
        said.append(
            f"  proven: a ball of {1e3 * proof.radius:.0f} mm in {proof.body} is shut in "
            f"{proof.cells} cells of {1e3 * proof.cell:.1f} mm"
        )
    elif found.status == motion.PathStatus.NO_PATH_FOUND:
        said.append(f"  the trees came {1e3 * found.nearest:.0f} mm near each other; no proof")
    return said
