"""VAMP's problems for the Panda: scenes, starts and goals, read from its archive."""

from __future__ import annotations

import subprocess
import sys
import tarfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

HERE = Path(__file__).parent
# Those of VAMP's own build that do not forbid infinity, which its trees of neighbours use.
FLAGS = (
    *("-O2", "-std=c++17", "-march=native", "-w", "-ffp-contract=fast", "-fassociative-math"),
    *("-fno-math-errno", "-fno-signed-zeros", "-fno-trapping-math", "-fno-rounding-math"),
)
JOINTS = [f"panda_joint{number}" for number in range(1, 8)]


@dataclass(frozen=True)
class Problem:
    """A scene with a start and a goal, as VAMP has them.

    Attributes
    ----------
    family : str
        The set that it is of.
    number : int
    rows : dict of str to ndarray
        Spheres (x, y, z, r), capsules (two ends, r) and boxes (centre, half lengths, axes one
        after the other). Cylinders are capsules, as in VAMP, and boxes in the set "box".
    start, goal : ndarray, shape (7,), rad
    """

    family: str
    number: int
    rows: dict[str, np.ndarray]
    start: np.ndarray
    goal: np.ndarray

    @property
    def name(self) -> str:
        """The set and the number."""
        return f"{self.family} {self.number}"

    @property
    def things(self) -> int:
        """How many primitives there are."""
        return sum(map(len, self.rows.values()))


def build(name: str, sources: Path, folder: Path) -> Path:
    """Compile one of the programs here with VAMP's headers."""
    program = folder / name
    subprocess.run(
        [
            *("g++", *FLAGS, str(HERE / f"{name}.cpp"), f"-I{sources / 'src/impl'}"),
            *("-I/usr/include/eigen3", "-o", str(program)),
        ],
        check=True,
    )
    return program


def of_sources(sources: Path, each: int | None = None) -> list[Problem]:
    """Read the problems of VAMP's sources, or end with what is missing."""
    archive = sources / "resources/panda/problems.tar.bz2"
    if not (sources / "src/impl/vamp").is_dir() or not archive.is_file():
        sys.exit(f"--sources: {sources} has no src/impl/vamp or no {archive.name}")
    return read(archive, each)


def transform(given: dict) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(given["orientation"]).as_matrix()
    matrix[:3, 3] = given["position"]
    return matrix


def read(archive: Path, each: int | None = None) -> list[Problem]:
    """Read all problems, or the first so many of each set."""
    found: dict[tuple[str, int], dict] = {}
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    with tarfile.open(archive) as packed:
        for member in packed:
            if not member.isfile():
                continue
            _, family, name = member.name.split("/")
            kind, number = name[:-9], int(name[-9:-5])
            if each is not None and number > each:
                continue
            file = packed.extractfile(member)
            key = family.removesuffix("_panda"), number
            found.setdefault(key, {})[kind] = yaml.load(file, loader) if file else {}
    return [problem(key, found[key]["scene"], found[key]["request"]) for key in sorted(found)]


def problem(key: tuple[str, int], scene: dict, request: dict) -> Problem:
    rows: dict[str, list] = {"spheres": [], "capsules": [], "boxes": []}
    for thing in scene["world"]["collision_objects"]:
        base = transform(thing["pose"]) if "pose" in thing else np.eye(4)
        shape = thing["primitives"][0]
        at = base @ transform(thing["primitive_poses"][0])
        size = shape["dimensions"]
        if shape["type"] == "sphere":
            rows["spheres"].append([*at[:3, 3], size[0]])
        elif shape["type"] == "cylinder" and key[0] != "box":
            half = 0.5 * size[0] * at[:3, 2]
            rows["capsules"].append([*(at[:3, 3] - half), *(at[:3, 3] + half), size[1]])
        else:
            if shape["type"] == "cylinder":
                halves = np.array([size[1], size[1], 0.5 * size[0]])
            else:
                halves = 0.5 * np.array(size)
            rows["boxes"].append([*at[:3, 3], *halves, *at[:3, :3].T.ravel()])
    widths = {"spheres": 4, "capsules": 7, "boxes": 15}
    state = request["start_state"]["joint_state"]
    start = dict(zip(state["name"], state["position"], strict=True))
    wanted = request["goal_constraints"][0]["joint_constraints"]
    goal = {one["joint_name"]: one["position"] for one in wanted}
    return Problem(
        *key,
        {kind: np.reshape(rows[kind], (-1, widths[kind])) for kind in rows},
        np.array([start[joint] for joint in JOINTS], float),
        np.array([goal[joint] for joint in JOINTS], float),
    )
