"""``agrik-fast harvest``: every fruit of a scene, decided and written to a folder."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from .. import harvest
from .._atomic import write_bytes
from ..collision import Scene
from ..errors import ArgumentError
from ..harvest import Evaluation
from ..jobs import RobotChoice
from ._options import numbers


def settings_of(
    *, refine: bool, recovery: bool, tilt_deg: float, shift: float, min_distance: float
) -> harvest.Settings:
    """Return the settings that options name.

    Raises
    ------
    ArgumentError
        A number out of its range.
    """
    return harvest.Settings(
        refine=refine,
        recovery=recovery,
        tilt=math.radians(tilt_deg),
        shift=shift,
        min_distance=min_distance,
    )


def evaluate(
    scene: Path,
    robot: RobotChoice,
    distance: str,
    *,
    settings: harvest.Settings,
    blockers: bool,
    threads: int | None,
    progress: Callable[[int, int], object],
) -> Evaluation:
    """Decide for every target of a scene file.

    Raises
    ------
    AgrikError
        A faulty file or robot, a scene without fruit, an option out of its range.
    """
    return harvest.evaluate(
        Scene.load(scene),
        robot.load(),
        settings=settings,
        distance=distance,  # type: ignore[arg-type]
        blockers=blockers,
        threads=threads,
        progress=progress,
    )


def write_paths(
    found: Evaluation, directory: Path, *, start: str | None, threads: int | None
) -> tuple[Path, str]:
    """Plan the ways into the postures of all fruits; return the file and what is said of it."""
    import json

    arm = found.robot
    first = arm.home if start is None else numbers("--start", start, (arm.dof,))
    decided = harvest.plan(
        arm, found.scene, settings=found.settings, path=True, start=first, threads=threads
    )
    rows = [
        {
            "name": one.name,
            "posture": one.status.name,
            "path": path.status.name,
            "how": path.how,
            "q": path.path.tolist(),
            "clearance_m": path.clearance.tolist(),
            "blockers_path": one.blockers_path,
            "blockers_fewest": None if one.blockers_fewest is None else one.blockers_fewest.name,
        }
        for one, path in zip(decided, decided.paths, strict=True)
    ]
    file = directory / "paths.json"
    content = {"robot": arm.name, "joints": list(arm.joint_names), "paths": rows}

    def refuse(reason: str) -> ArgumentError:
        return ArgumentError("output", f"{file}: {reason}", "a file that can be written")

    write_bytes(file, (json.dumps(content) + "\n").encode(), refuse, force=True)
    ways, postures = int(decided.reachable_path.sum()), int(decided.ok.sum())
    return file, f"{ways} of {postures} fruits with a posture have a way into one"


def check_folder(directory: Path, *, force: bool) -> None:
    """Refuse a folder that holds files, unless `force`."""
    if directory.exists() and not directory.is_dir():
        raise ArgumentError("output", f"the file {directory}", "a folder")
    if directory.is_dir() and any(directory.iterdir()) and not force:
        raise ArgumentError(
            "output", f"{directory}, which holds files", "an empty or new folder (or --force)"
        )


def lines(found: Evaluation) -> list[str]:
    """Return what is said of an evaluation at its end."""
    shares = found.shares()
    said = [
        f"{len(found.decisions)} fruits in {found.seconds:.3g} s: "
        + ", ".join(f"{name} {100 * shares[name]:.1f} %" for name in ("ok", "blocked", "none"))
    ]
    said += [f"  {name}: {100 * share:.1f} %" for name, share in found.decisions.shares().items()]
    worst = found.leaves()[:5]
    if worst:
        said.append("in the way: " + ", ".join(f"{name} ({count})" for name, count in worst))
    return said
