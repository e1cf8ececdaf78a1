"""Arms and scenes of the solids' test data, as the compiled core takes them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import agrik_fast as ik
from agrik_fast import _native

DATA = Path(__file__).parents[2] / "rust/agrik-solids/tests/data"
SCENES = {
    "cucumber": ("scene", "greenhouse1", "greenhouse2"),
    "panda": ("bench", "wall", "greenhouse5"),
}
# Arms of the package, in the Panda's scenes.
BUNDLED = ("ur5", "redundant7")


def read(name: str) -> dict:
    return json.loads((DATA / f"{name}.json").read_text())


@dataclass(frozen=True)
class Arm:
    """An arm with its bodies, and what it does not mind."""

    name: str
    unit: float
    chain: _native.Chain
    bodies: _native.Bodies
    skip: list[tuple[str, str]]

    @classmethod
    def of(cls, name: str) -> Arm:
        file = read(name)
        unit = 1e-3 if file["unit"] == "mm" else 1.0

        def pose(rows: list[list[float]]) -> np.ndarray:
            matrix = np.array(rows, float)
            matrix[:3, 3] *= unit
            return matrix

        joints = []
        for number, joint in enumerate(file["joints"], start=1):
            slides = joint["type"] == "P"
            scale = unit if slides else 1.0
            joints.append(
                {
                    "name": f"q{number}",
                    "type": "prismatic" if slides else "revolute",
                    "origin": pose(joint["C"]),
                    "axis": [0, 0, 1],
                    "lower": joint["lo"] * scale,
                    "upper": joint["hi"] * scale,
                    "mimic": None,
                }
            )
        chain = _native.Chain.from_joints(name, joints, pose(file["base"]), pose(file["tool"]))
        names = [body["name"] for body in file["bodies"]]
        kinds, cores = [], []
        for body in file["bodies"]:
            if body["shape"] == "box":
                turn = np.array(body.get("R", np.eye(3)))
                half = np.array(body["half"]) * unit
                kinds.append("box")
                cores.append((np.array(body["centre"]) * unit, half, turn))
            else:
                kinds.append("capsule")
                cores.append(np.array([body["a"], body["b"]]) * unit)
        radii = [body.get("radius", 0.0) * unit for body in file["bodies"]]
        frames = [body["frame"] for body in file["bodies"]]
        pairs = [(names.index(a), names.index(b)) for a, b in file["self_pairs"]]
        bodies = _native.Bodies(chain, names, frames, kinds, cores, radii, pairs)
        return cls(name, unit, chain, bodies, [tuple(pair) for pair in file.get("static_skip", [])])

    @classmethod
    def bundled(cls, name: str) -> Arm:
        robot = ik.Robot.load(name)
        skip = [tuple(pair) for pair in robot.collision_rules.static_skip]
        return cls(name, 1.0, robot._chain, robot.compiled_bodies(), skip)

    def postures(self, count: int, seed: int = 1) -> np.ndarray:
        rng = np.random.default_rng(seed)
        return rng.uniform(self.chain.lower, self.chain.upper, (count, self.chain.dof))

    def among(self, scene: _native.Scene) -> _native.Collider:
        names = self.bodies.names
        pairs = [
            (names.index(body), scene.names.index(thing))
            for body, thing in self.skip
            if thing in scene.names
        ]
        return _native.Collider(self.bodies, scene, pairs)


class Things:
    """Rows of a scene file, in metres."""

    def __init__(self, objects: list[dict], unit: float) -> None:
        self.names = [thing["name"] for thing in objects]
        self.rows: dict[str, list] = {}
        self.labels: dict[str, list[int]] = {}

        def add(kind: str, label: int, row: object) -> None:
            self.rows.setdefault(kind, []).append(row)
            self.labels.setdefault(kind, []).append(label)

        for label, thing in enumerate(objects):
            for row in thing.get("spheres", []):
                add("sphere", label, np.array(row) * unit)
            for row in thing.get("capsules", []):
                add("capsule", label, np.array(row) * unit)
            for box in thing.get("boxes", []):
                turn = np.ravel(box.get("R", np.eye(3)))
                sizes = np.array([*box["centre"], *box["half"]]) * unit
                add("box", label, np.array([*sizes, *turn, 0.0]))
            for row in thing.get("halfspaces", []):
                add("halfspace", label, np.array([*row[:3], row[3] * unit]))

    @classmethod
    def of(cls, arm: Arm, scene: str) -> Things:
        whose = "panda" if arm.name in BUNDLED else arm.name
        return cls(read(f"scenes_{whose}")[scene]["objects"], arm.unit)

    def made(self) -> _native.Scene:
        plural = {"sphere": "spheres", "capsule": "capsules", "box": "boxes"}
        given = {}
        for kind, rows in self.rows.items():
            given[plural.get(kind, "halfspaces")] = np.array(rows)
            given[f"{kind}_labels"] = np.array(self.labels[kind])
        return _native.Scene(self.names, **given)

    def in_a_row(self, times: int) -> Things:
        """Return this scene so many times, one beside the other along y."""
        spheres = np.array(self.rows["sphere"])
        length = np.ptp(spheres[:, 1]) + 0.1
        copy = Things([], 1.0)
        copy.names = self.names
        copy.rows = dict(self.rows)
        copy.labels = dict(self.labels)
        shifts = [step // 2 * (-1) ** step for step in range(1, times + 1)]
        moved = [spheres + np.array([0, shift * length, 0, 0]) for shift in shifts]
        copy.rows["sphere"] = list(np.concatenate(moved))
        copy.labels["sphere"] = list(self.labels["sphere"]) * times
        return copy

    def denser(self, times: int, seed: int = 0) -> Things:
        """Return so many times the points in the same volume, each near one of these."""
        rng = np.random.default_rng(seed)
        spheres = np.repeat(np.array(self.rows["sphere"]), times, axis=0)
        spheres[:, :3] += rng.normal(scale=0.03, size=(len(spheres), 3))
        copy = Things([], 1.0)
        copy.names = self.names
        copy.rows = self.rows | {"sphere": list(spheres)}
        copy.labels = self.labels | {"sphere": list(np.repeat(self.labels["sphere"], times))}
        return copy
