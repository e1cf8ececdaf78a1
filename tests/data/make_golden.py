"""Extract the robots' golden kinematics from the specification's reference data.

    python tests/data/make_golden.py PATH_TO_SHARED

PATH_TO_SHARED holds `spec/<robot>/reference.json` and `peers/robots/robots.json`.
Writes `golden_kinematics.json` beside this script, in the specification's own
units (named per robot). Nothing is computed here: numbers are copied.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent


def strawberry(reference: dict[str, Any]) -> dict[str, Any]:
    """Joint vectors of four rows of table 3 with the target each one reaches."""
    key = "q_s10_s21_s32_theta_beta"
    cases = [
        {"row": row["row"], "method": method, "q": row[method][key], "p": row["target_used"]}
        for row in reference["rows"]
        for method in ("NCOS", "NCOS_SLSQP", "SSAS", "AS")
    ]
    return {"units": "mm, rad", "constants": reference["constants"], "cases": cases}


def cucumber(reference: dict[str, Any]) -> dict[str, Any]:
    """Poses in the world frame and in frame 0, regular and singular."""
    keys = ("q", "tcp_world", "tcp_frame0")
    return {
        "units": "mm, rad",
        "tolerance": reference["tolerance"],
        "cases": [{k: case[k] for k in keys} for case in reference["cases"]],
        "special": [
            {k: case[k] for k in ("name", *keys)} for case in reference["special"] if "q" in case
        ],
    }


def hydrolek(reference: dict[str, Any]) -> dict[str, Any]:
    """Poses and Jacobians in the D-H base frame and in the paper's frame."""
    return {"units": "mm, rad", "fk": reference["fk"], "jacobian": reference["jacobian"]}


def tomato(reference: dict[str, Any]) -> dict[str, Any]:
    """Tool points and Jacobians; closed-form branches of a few targets."""
    keys = ("units", "L1", "L2", "fk", "analytic")
    return {key: reference[key] for key in keys}


def redundant7(reference: dict[str, Any]) -> dict[str, Any]:
    """Poses, limits, and five joint vectors that solve the published target."""
    keys = ("units", "limits", "fk", "published", "valid_solutions_table_I", "q4_abs_required")
    return {key: reference[key] for key in keys}


def main(shared: Path) -> None:
    """Write the golden file."""
    golden: dict[str, Any] = {}
    for extract in (strawberry, cucumber, hydrolek, tomato, redundant7):
        name = extract.__name__
        reference = json.loads((shared / "spec" / name / "reference.json").read_text())
        golden[name] = extract(reference)
    golden["peers"] = json.loads((shared / "peers" / "robots" / "robots.json").read_text())
    text = json.dumps(golden, indent=1, sort_keys=True)
    (HERE / "golden_kinematics.json").write_text(text + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
