"""Robots from files, read apart from the library: URDFs of two packages, and the bundled TOML."""

from __future__ import annotations

import tomllib
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import agrik_fast as ik

from .chain import Arm, Array, Joint, from_rpy, rotation, transform, unit

BUNDLED = Path(ik.__file__).resolve().parent / "robot" / "bundled"
MOVING = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class Urdf:
    """A file of a package and the chain in it that is asked for."""

    file: str
    tip: str
    base: str | None = None

    def path(self, packages: Path) -> Path:
        """Return where the file is below a folder of installed packages."""
        found = sorted(p for p in packages.rglob(Path(self.file).name) if p.match("*/" + self.file))
        if not found:
            raise FileNotFoundError(f"no {self.file} below the folder of --packages")
        return found[0]


ROBOTS = {
    "Panda": Urdf("panda_description/urdf/panda.urdf", "panda_hand_tcp"),
    "Panda with finger": Urdf("panda_description/urdf/panda.urdf", "panda_leftfinger"),
    "UR3": Urdf("ur_description/urdf/ur3_robot.urdf", "tool0"),
    "UR5": Urdf("ur_description/urdf/ur5_robot.urdf", "tool0"),
    "UR5, limited": Urdf("ur_description/urdf/ur5_joint_limited_robot.urdf", "tool0"),
    "UR10": Urdf("ur_description/urdf/ur10_robot.urdf", "tool0"),
    "UR10, limited": Urdf("ur_description/urdf/ur10_joint_limited_robot.urdf", "tool0"),
    "Kinova j2s6s200": Urdf("kinova_description/robots/kinova.urdf", "j2s6s200_end_effector"),
    "xArm7": Urdf("xarm_description/urdf/xarm7.urdf", "link_eef"),
    "Unitree Z1": Urdf("z1_description/urdf/z1.urdf", "link06"),
    "SO-100": Urdf("so_arm_description/urdf/so100.urdf", "jaw"),
    "SO-101": Urdf("so_arm_description/urdf/so101.urdf", "gripper_frame_link"),
    "TALOS arm": Urdf("talos_data/robots/talos_left_arm.urdf", "gripper_left_motor_double_link"),
    "TALOS arm and torso": Urdf(
        "talos_data/robots/talos_reduced.urdf", "gripper_left_motor_double_link", "base_link"
    ),
    "TIAGo": Urdf("tiago_description/robots/tiago_no_hand.urdf", "wrist_ft_tool_link"),
    "TIAGo Pro": Urdf(
        "tiago_pro_description/robots/tiago_pro.urdf", "gripper_left_outer_finger_left_link"
    ),
    "Baxter": Urdf("baxter_description/urdf/baxter.urdf", "left_hand_camera_link"),
    "PR2": Urdf("pr2_description/urdf/pr2.urdf", "r_gripper_tool_frame"),
    "Romeo": Urdf("romeo_description/urdf/romeo_laas_small.urdf", "LArm_effector"),
    "iCub": Urdf("icub_description/robots/icub.urdf", "l_hand_dh_frame"),
    "Alex": Urdf("alex_description/urdf/alex_nub_hands.urdf", "leftNub"),
    "Centauro": Urdf("centauro_description/urdf/centauro.urdf", "arm1_8"),
    "G1": Urdf("g1_description/urdf/g1_29dof_rev_1_0.urdf", "left_rubber_hand"),
    "IRB 140": Urdf("abb_irb140_description/urdf/irb140.urdf", "tool0"),
    "KR 16": Urdf("kuka_kr16/urdf/kr16_2.urdf", "tool0"),
    "KR 120": Urdf("kuka_kr120/urdf/kr120r2500pro.urdf", "tool0"),
    "KR 210": Urdf("kuka_kr210/urdf/kr210l150.urdf", "tool0"),
    "LBR iiwa 14": Urdf("kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf", "tool0"),
    "PUMA 560 of rtb-data": Urdf("unimation_puma560_description/urdf/puma560_robot.urdf", "link7"),
}
"""Arms as their authors wrote them down, of `example-robot-data` and `rtb-data`."""


def from_urdf(name: str, urdf: Urdf, packages: Path) -> tuple[Arm, ik.Robot]:
    """Read one chain of a URDF twice: by ourselves, and by the library."""
    path = urdf.path(packages)
    robot = ik.Robot.from_urdf(path, base_link=urdf.base, tip_link=urdf.tip)
    arm = read_urdf(name, path.read_text(encoding="utf-8"), urdf.base, urdf.tip)
    return arm.ordered(robot.joint_names), robot


def read_urdf(name: str, text: str, base: str | None, tip: str) -> Arm:
    """Read the chain from `base` (default: the root) to `tip`."""
    elements = [e for e in ET.fromstring(text).findall("joint") if e.find("parent") is not None]
    above = {_link(e, "child"): e for e in elements}
    by_name = {e.get("name", ""): e for e in elements}
    chain: list[ET.Element] = []
    link = tip
    while link in above and link != base:
        chain.insert(0, above[link])
        link = _link(above[link], "parent")
    joints = []
    before = np.eye(4)
    for element in chain:
        before = before @ _origin(element)
        kind = element.get("type", "")
        if kind in MOVING:
            low, high = _range(element)
            axis = _numbers(element.find("axis"), "xyz", (1.0, 0.0, 0.0))
            follows = _mimic(element, by_name)
            joints.append(
                Joint(element.get("name", ""), kind, before, unit(axis), low, high, follows)
            )
            before = np.eye(4)
        elif kind != "fixed":
            raise ValueError(f"{name}: joints of type {kind!r} are not read")
    return _measured(Arm(name, tuple(joints), before, kind="URDF"))


def _measured(arm: Arm) -> Arm:
    """Return the arm with its length as its scale: what slides without limits are drawn to."""
    return replace(arm, scale=arm.length)


def _link(element: ET.Element, which: str) -> str:
    found = element.find(which)
    assert found is not None
    return found.get("link", "")


def _origin(element: ET.Element) -> Array:
    origin = element.find("origin")
    return transform(
        from_rpy(_numbers(origin, "rpy", (0.0, 0.0, 0.0))),
        _numbers(origin, "xyz", (0.0, 0.0, 0.0)),
    )


def _numbers(element: ET.Element | None, key: str, default: tuple[float, ...]) -> Array:
    text = None if element is None else element.get(key)
    return np.array(default if text is None else [float(word) for word in text.split()])


def _range(element: ET.Element) -> tuple[float, float]:
    limit = element.find("limit")
    if element.get("type") == "continuous" or limit is None:
        return -np.inf, np.inf
    return float(limit.get("lower", "0")), float(limit.get("upper", "0"))


def _mimic(
    element: ET.Element, by_name: Mapping[str, ET.Element]
) -> tuple[str, float, float] | None:
    rule = element.find("mimic")
    if rule is None:
        return None
    source = by_name[rule.get("joint", "")]
    if source.find("mimic") is not None:
        raise ValueError("a follower of a follower is not read")
    return (
        source.get("name", ""),
        float(rule.get("multiplier", "1")),
        float(rule.get("offset", "0")),
    )


# ---- bundled robots ------------------------------------------------------------------------------

_TO_SI = {"m": 1.0, "mm": 1e-3, "rad": 1.0, "deg": np.pi / 180.0}


def bundled(name: str) -> tuple[Arm, ik.Robot]:
    """Read a bundled robot twice: by ourselves, and by the library."""
    robot = ik.Robot.load(name)
    with (BUNDLED / f"{name}.toml").open("rb") as file:
        content = tomllib.load(file)
    read = _dh if "dh" in content else _joints
    joints, end = read(content, _frame(content.get("base", {})))
    arm = Arm(name, tuple(joints), end @ _frame(content.get("tool", {})), kind="bundled")
    return _measured(arm.ordered(robot.joint_names)), robot


def _si(table: Mapping[str, Any], key: str, default: Any = 0.0) -> Any:
    for unit_name, factor in _TO_SI.items():
        if f"{key}_{unit_name}" in table:
            return np.asarray(table[f"{key}_{unit_name}"], float) * factor
    return np.asarray(default, float)


def _frame(table: Mapping[str, Any]) -> Array:
    point = _si(table, "xyz", np.zeros(3))
    if "rotation" in table:
        return transform(np.asarray(table["rotation"], float), point)
    return transform(from_rpy(_si(table, "rpy", np.zeros(3))), point)


def _ends(row: Mapping[str, Any]) -> tuple[float, float]:
    return float(_si(row, "lower", -np.inf)), float(_si(row, "upper", np.inf))


def _dh(content: Mapping[str, Any], before: Array) -> tuple[list[Joint], Array]:
    joints = []
    for row in content["dh"]:
        along = transform(rotation((0, 0, 1), float(_si(row, "theta"))), (0, 0, _si(row, "d")))
        across = transform(rotation((1, 0, 0), float(_si(row, "alpha"))), (_si(row, "a"), 0, 0))
        modified = content.get("convention", "standard") == "modified"
        before = before @ across @ along if modified else before
        if row["type"] != "fixed":
            axis = np.array([0.0, 0.0, 1.0])
            joints.append(Joint(row["name"], row["type"], before, axis, *_ends(row)))
            before = np.eye(4)
        before = before if modified else before @ along @ across
    return joints, before


def _joints(content: Mapping[str, Any], before: Array) -> tuple[list[Joint], Array]:
    joints = []
    for row in content["joint"]:
        before = before @ _frame(row)
        if row["type"] == "fixed":
            continue
        rule = row.get("mimic")
        follows = rule and (
            rule["joint"], float(rule.get("multiplier", 1.0)), float(_si(rule, "offset"))
        )  # fmt: skip
        axis = unit(row.get("axis", (0.0, 0.0, 1.0)))
        joints.append(Joint(row["name"], row["type"], before, axis, *_ends(row), follows))
        before = np.eye(4)
    return joints, before
