"""Sound files of every kind, and what reads them."""

from __future__ import annotations

import contextlib
import csv
import io
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow
from pyarrow import parquet

import agrik_fast as ik
from agrik_fast import AgrikError
from agrik_fast.io import read_results
from agrik_fast.jobs import SolveRequest, solve_file
from agrik_fast.solvers import gain_file
from agrik_fast.tuning import Tuning, tune

QUICK = Tuning(goals=20, evaluations=40, runs=1, refinement=0)
URDF = """<?xml version="1.0"?>
<robot name="arm">
  <link name="base"/><link name="upper"/><link name="lower"/><link name="tool"/>
  <joint name="a" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.3" rpy="0 0 0"/><axis xyz="0 0 1"/><limit lower="-2" upper="2"/></joint>
  <joint name="b" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.2 0 0" rpy="1.5707963 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2"/></joint>
  <joint name="c" type="prismatic"><parent link="lower"/><child link="tool"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.4"/></joint>
</robot>
"""


class Case(NamedTuple):
    """A file and what reads it."""

    name: str
    data: bytes
    read: Callable[[Path], object]


def solve(path: Path) -> None:
    """Solve a target file as the command does, with results of a kind that shows all."""
    output = path.with_name("result.csv")
    solve_file(SolveRequest(robot="ur5", targets=path, output=output, solver="auto", force=True))
    with output.open(encoding="utf-8", newline="") as stream:
        rows = sum(1 for _ in csv.reader(stream)) - 1
    if rows < 1:
        raise AssertionError("a target file without targets was accepted")


def load_robot(path: Path) -> None:
    arm = ik.Robot.load(path)
    if not np.isfinite(arm.fk(np.clip(np.zeros(arm.dof), arm.lower, arm.upper))).all():
        raise AssertionError("a robot whose tool is nowhere was accepted")


def resume(path: Path) -> None:
    tune(ik.Robot.load("hydrolek"), QUICK, checkpoint=path, resume=True)


def savez(**arrays: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)
    return stream.getvalue()


def save(array: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def table(**columns: object) -> bytes:
    stream = io.BytesIO()
    parquet.write_table(pyarrow.table(columns), stream)
    return stream.getvalue()


def checkpoint(folder: Path) -> bytes:
    """Return the checkpoint of a search whose gains could not be stored."""
    path = folder / "kept.npz"

    def fail(_: object) -> None:
        raise AgrikError("no room")

    with contextlib.suppress(AgrikError):
        tune(ik.Robot.load("hydrolek"), QUICK, checkpoint=path, store=fail)
    return path.read_bytes()


def sound_files(folder: Path) -> list[Case]:
    """Return a sound file of every kind."""
    arm = ik.Robot.load("ur5")
    poses = arm.fk(arm.random_q(40, seed=1))
    points = poses[:, :3, 3]
    ids = np.array([f"row {k}" for k in range(len(points))])
    lines = ["id,x_m,y_m,z_m,qx,qy,qz,qw"]
    lines += [
        f"{k},{x!r},{y!r},{z!r},0,0,0,1" for k, (x, y, z) in zip(ids, points.tolist(), strict=True)
    ]
    text = "\n".join(lines).encode()
    results = []
    for suffix in ("csv", "npy", "npz", "parquet"):
        source, target = folder / "sound.csv", folder / f"sound_result.{suffix}"
        source.write_bytes(text)
        solve_file(SolveRequest(robot="ur5", targets=source, output=target, force=True))
        results.append(Case(f"result.{suffix}", target.read_bytes(), read_results))
    gains = gain_file.read("hydrolek_full90_pso")
    bundled = Path(ik.__file__).parent / "robot" / "bundled"
    return [
        Case("targets.csv", text, solve),
        Case("points.npy", save(points), solve),
        Case("poses.npy", save(np.asfortranarray(poses)), solve),
        Case("points.npz", savez(position_m=points, rpy_deg=points * 100, id=ids), solve),
        Case("poses.npz", savez(T=poses, id=np.arange(40)), solve),
        Case(
            "targets.parquet",
            table(id=ids, **{f"{axis}_m": points[:, k] for k, axis in enumerate("xyz")}),
            solve,
        ),
        *results,
        *(
            Case(f"{name}.toml", (bundled / f"{name}.toml").read_bytes(), load_robot)
            for name in ("ur5", "strawberry", "redundant7")
        ),
        Case("gains.toml", gain_file.text(Path("x.toml"), gains).encode(), gain_file.read),
        Case("gains.json", gain_file.text(Path("x.json"), gains).encode(), gain_file.read),
        Case("arm.urdf", URDF.encode(), load_robot),
        Case("kept.npz", checkpoint(folder), resume),
    ]
