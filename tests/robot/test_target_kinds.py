"""Targets as other libraries hold them: the same answers as their matrices."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import agrik_fast as ik

ARM = ik.Robot.load("ur5")
POSES = ARM.fk(ARM.random_q(40, seed=3))
WANTED = ARM.ik(POSES)
QUATERNIONS = ik.rotations.quat_of(POSES)
PLACES = POSES[:, :3, 3]


def answers(targets: Any, **options: Any) -> None:
    """Solve targets, whose matrices may differ from the usual ones by rounding."""
    found = ARM.ik(targets, **options)
    assert found.q.shape == WANTED.q.shape
    assert found.success.all()
    np.testing.assert_allclose(ARM.fk(found.q), POSES, rtol=0, atol=2e-6)


@pytest.mark.parametrize("order", ["xyz_xyzw", "xyz_wxyz", "xyzw_xyz", "wxyz_xyz"])
def test_rows_of_seven_numbers_in_a_named_order(order: str) -> None:
    x, y, z, w = QUATERNIONS.T
    turns = np.column_stack([x, y, z, w] if "xyzw" in order else [w, x, y, z])
    rows = np.hstack([PLACES, turns] if order.startswith("xyz_") else [turns, PLACES])
    answers(rows, order=order)
    answers(rows.tolist(), order=order)
    answers(rows.astype(np.float32), order=order)
    assert ARM.ik(rows[0], order=order).q.shape == (6,)
    assert ARM.ik(rows.reshape(4, 10, 7), order=order).q.shape == (4, 10, 6)
    every = ARM.ik_all(rows[:3], order=order)
    np.testing.assert_array_equal(every.status, ARM.ik_all(POSES[:3]).status)
    path = ARM.follow(rows[:2], order=order)
    assert path.success.all()
    (streamed,) = ARM.ik_stream([rows], order=order)
    assert streamed.success.all()


def test_an_order_belongs_to_seven_numbers() -> None:
    rows = np.hstack([PLACES, QUATERNIONS])
    with pytest.raises(ik.ArgumentError, match="order= for seven numbers"):
        ARM.ik(rows)
    with pytest.raises(ik.ArgumentError, match=r"`targets`: expected shape \(\.\.\., 7\)"):
        ARM.ik(POSES, order="xyz_xyzw")
    with pytest.raises(ik.UnknownNameError, match="unknown order 'xyzquat'"):
        ARM.ik(rows, order="xyzquat")  # type: ignore[arg-type]


def test_quaternions_that_are_none() -> None:
    rows = np.hstack([PLACES, QUATERNIONS])[:4].copy()
    rows[1, 3:] *= 1.01
    rows[2, 3] = np.nan
    rows[3, 3:] = 0
    marked = ARM.ik(rows, order="xyz_xyzw")
    np.testing.assert_array_equal(marked.status == ik.Status.BAD_INPUT, [False, True, True, True])
    straight = ARM.ik(rows, order="xyz_xyzw", invalid="straighten")
    np.testing.assert_array_equal(straight.success, [True, True, False, False])
    with pytest.raises(ik.ArgumentError, match=r"`targets\[1\]`: expected a quaternion of length"):
        ARM.ik(rows, order="xyz_xyzw", invalid="raise")


def test_scipys_rotations_and_places() -> None:
    turns = Rotation.from_quat(QUATERNIONS)
    answers((PLACES, turns))
    answers((turns, PLACES.tolist()))
    answers([PLACES, turns])
    one = ARM.ik((PLACES[0], turns[0]))
    assert one.success
    assert ARM.ik((PLACES[:5], turns[0])).q.shape == (5, 6)
    with pytest.raises(ik.ArgumentError, match="as many places as rotations"):
        ARM.ik((PLACES[:5], turns[:4]))
    with pytest.raises(ik.ArgumentError, match="places of shape"):
        ARM.ik((QUATERNIONS, turns))
    with pytest.raises(ik.ArgumentError, match="a pair: places"):
        ARM.ik(turns)


class HasArray:
    """A pose as Pinocchio's `SE3` is one."""

    def __init__(self, pose: np.ndarray[Any, Any]) -> None:
        self.homogeneous = pose

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray[Any, Any]:
        return np.asarray(self.homogeneous, dtype=dtype)


class Homogeneous:
    """A pose that can only be asked for its matrix."""

    def __init__(self, pose: np.ndarray[Any, Any]) -> None:
        self.homogeneous = pose


class AsMatrix(Homogeneous):
    """A pose as SciPy's `RigidTransform` is one."""

    def as_matrix(self) -> np.ndarray[Any, Any]:
        return self.homogeneous


@pytest.mark.parametrize("kind", [HasArray, Homogeneous, AsMatrix])
def test_poses_that_are_objects(kind: Any) -> None:
    np.testing.assert_array_equal(ARM.ik(kind(POSES[0])).q, ARM.ik(POSES[0]).q)
    found = ARM.ik([kind(pose) for pose in POSES])
    np.testing.assert_array_equal(found.q, WANTED.q)
    np.testing.assert_array_equal(ARM.ik(kind(POSES)).q, WANTED.q)


class Tensor:
    """Numbers of another library: DLPack, and nothing else."""

    def __init__(self, array: np.ndarray[Any, Any], device: int = 1, needs: bool = False) -> None:
        self._array = array
        self._device = device
        self.requires_grad = needs

    def __dlpack__(self, **options: Any) -> Any:
        return self._array.__dlpack__(**options)

    def __dlpack_device__(self) -> tuple[int, int]:
        return self._device, 0


def test_tensors_with_dlpack() -> None:
    np.testing.assert_array_equal(ARM.ik(Tensor(POSES)).q, WANTED.q)
    answers(Tensor(POSES.astype(np.float32)))
    rows = np.hstack([PLACES, QUATERNIONS])
    answers(Tensor(rows), order="xyz_xyzw")
    stacked = ARM.ik([Tensor(pose) for pose in POSES[:3]])
    np.testing.assert_array_equal(stacked.q, WANTED.q[:3])
    with pytest.raises(ik.ArgumentError, match="a tensor on another device"):
        ARM.ik(Tensor(POSES, device=2))
    with pytest.raises(ik.ArgumentError, match=r"agrik_fast\.torch\.ik, which passes gradients"):
        ARM.ik(Tensor(POSES, needs=True))
    half = Tensor(POSES.astype(np.complex128))
    with pytest.raises(ik.ArgumentError, match="an array of complex128"):
        ARM.ik(half)
