"""Scenes and arms of the specifications' own files, as this library has them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

import agrik_fast as ik
from agrik_fast.collision import Scene, from_document

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT / "rust/agrik-solids/tests/data"
UNITS = {"cucumber": "mm", "panda": "m"}
PER_METRE = {"cucumber": 1000.0, "panda": 1.0}
# All bundled arms have bodies.
WITH_BODIES = tuple(ik.Robot.names())


def read(name: str) -> Any:
    """Return a file of the test data."""
    return json.loads((DATA / f"{name}.json").read_text())


def scenes(arm: str) -> dict[str, Scene]:
    """Return the scenes of an arm's file, which leaves the unit to the arm."""
    return {
        name: from_document(
            {"unit": UNITS[arm], "objects": scene["objects"], "targets": scene.get("targets", {})},
            name=name,
        )
        for name, scene in read(f"scenes_{arm}").items()
    }


def cucumber_document() -> dict[str, Any]:
    """Return the cucumber's own scene file, whose boxes and rules stand apart, as ours."""
    raw = json.loads((ROOT / "tests/data/cucumber/scene.json").read_text())
    boxes = [
        {
            "name": box["name"],
            "kind": "machine",
            "boxes": [{"centre": box["centre"], "half": box["half"]}],
        }
        for box in raw["static_boxes"]
    ]
    targets = {
        name: {"point": point, "objects": [raw["target_fruit"][name], f"stalk_{name}"]}
        for name, point in raw["targets"].items()
    }
    targets |= {name: {"point": p, "objects": []} for name, p in raw["extra_targets"].items()}
    return {
        "unit": "mm",
        "about": raw["about"],
        "exemptions": raw["static_skip"],
        "targets": targets,
        "objects": [*raw["objects"], *boxes],
    }


def postures(arm: str) -> list[dict[str, Any]]:
    """Return the postures of an arm with the reference's distances."""
    return read(f"postures_{arm}")


def joint_values(arm: str, rows: list[dict[str, Any]]) -> np.ndarray:
    """Return the joint values of postures, m and rad."""
    q = np.array([row["q"] for row in rows])
    if arm == "cucumber":
        q[:, 0] /= 1000.0
    return q
