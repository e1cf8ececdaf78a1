"""Arrays and gradients of JAX."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import jax
import numpy as np
import pytest
from jax import numpy as jnp

import agrik_fast as ik
import agrik_fast.jax

UR5 = ik.Robot.load("ur5")
NEAR = np.array([0.3, -1.1, 1.2, -0.8, 1.3, 0.4]) + 0.1 * np.arange(18).reshape(3, 6) / 18
TIGHT: dict[str, Any] = {"position_tolerance": 1e-13, "orientation_tolerance": 1e-12}
WEIGHTS = np.random.default_rng(1).normal(size=(3, 6))


@pytest.fixture(autouse=True)
def doubles() -> Iterator[None]:
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", False)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_arrays_are_targets(kind: Any) -> None:
    poses = UR5.fk(UR5.random_q(20, seed=1))
    found = UR5.ik(jnp.asarray(poses, dtype=kind))
    assert found.success.all()
    if kind is np.float64:
        np.testing.assert_array_equal(found.q, UR5.ik(poses).q)


def weighed(targets: Any) -> Any:
    return (agrik_fast.jax.ik(UR5, targets, q0=NEAR, **TIGHT).q * WEIGHTS).sum()


@pytest.mark.parametrize("compiled", [False, True])
def test_gradients_of_poses_are_finite_differences(compiled: bool) -> None:
    poses = UR5.fk(NEAR)
    follow = jax.grad(weighed)
    gradient = np.asarray((jax.jit(follow) if compiled else follow)(jnp.asarray(poses)))
    step = 1e-4
    for j in range(6):
        ends = []
        for sign in (1, -1):
            moved = poses.copy()
            if j < 3:
                moved[:, j, 3] += sign * step
            else:
                turn = ik.rotations.pose((0, 0, 0), axis_angle=sign * step * np.eye(3)[j - 3])
                moved[:, :3, :3] = turn[:3, :3] @ moved[:, :3, :3]
            ends.append((moved, float(weighed(jnp.asarray(moved)))))
        (up, more), (down, less) = ends
        along = float((gradient * (up - down)).sum() / (2 * step))
        np.testing.assert_allclose(along, (more - less) / (2 * step), rtol=1e-6, atol=1e-6)


def test_one_program_for_many() -> None:
    poses = jnp.asarray(UR5.fk(NEAR))
    one = jax.jit(lambda pose: agrik_fast.jax.ik(UR5, pose, **TIGHT))
    many = jax.vmap(one)(poses)
    assert many.q.shape == (3, 6) and many.success.all() and (many.status == 0).all()
    np.testing.assert_allclose(UR5.fk(np.asarray(many.q)), poses, atol=1e-9)
    jacobians = jax.vmap(jax.jacrev(lambda pose: one(pose).q))(poses)
    assert jacobians.shape == (3, 6, 4, 4)


def test_there_and_back_is_the_identity() -> None:
    def back(q: Any) -> Any:
        poses = agrik_fast.jax.fk(UR5, q)
        return (agrik_fast.jax.ik(UR5, poses, q0=NEAR, **TIGHT).q * WEIGHTS).sum()

    gradient = jax.jit(jax.grad(back))(jnp.asarray(NEAR))
    np.testing.assert_allclose(gradient, WEIGHTS, rtol=0, atol=1e-6)


def test_points_and_single_numbers() -> None:
    jax.config.update("jax_enable_x64", False)
    points = jnp.asarray(UR5.fk(NEAR)[:, :3, 3])
    gradient = jax.grad(lambda at: agrik_fast.jax.ik(UR5, at, q0=NEAR).q.sum())(points)
    assert gradient.shape == (3, 3) and gradient.dtype == np.float32


def test_wrong_arguments_are_said() -> None:
    with pytest.raises(ik.ArgumentError, match="shape"):
        agrik_fast.jax.ik(UR5, jnp.eye(5))
    with pytest.raises(ik.ArgumentError, match="shape"):
        agrik_fast.jax.fk(UR5, jnp.zeros(5))
