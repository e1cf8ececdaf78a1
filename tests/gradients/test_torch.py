"""Tensors and gradients of PyTorch."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import torch

import agrik_fast as ik
import agrik_fast.torch

UR5 = ik.Robot.load("ur5")
NEAR = np.array([0.3, -1.1, 1.2, -0.8, 1.3, 0.4]) + 0.1 * np.arange(18).reshape(3, 6) / 18
TIGHT: dict[str, Any] = {"position_tolerance": 1e-13, "orientation_tolerance": 1e-12}


@pytest.mark.parametrize("kind", [torch.float32, torch.float64])
def test_tensors_are_targets(kind: Any) -> None:
    poses = UR5.fk(UR5.random_q(20, seed=1))
    tensor = torch.tensor(poses, dtype=kind)
    found = UR5.ik(tensor)
    assert found.success.all()
    if kind is torch.float64:
        np.testing.assert_array_equal(found.q, UR5.ik(poses).q)
    with pytest.raises(ik.ArgumentError, match="requires gradients"):
        UR5.ik(tensor.requires_grad_())


def weights() -> Any:
    return torch.tensor(np.random.default_rng(1).normal(size=(3, 6)))


def test_gradients_of_poses_are_finite_differences() -> None:
    poses = UR5.fk(NEAR)
    targets = torch.tensor(poses, requires_grad=True)
    answers = agrik_fast.torch.ik(UR5, targets, q0=NEAR, **TIGHT)
    assert answers.success.all() and answers.q.dtype == torch.float64
    assert (answers.status == 0).all()
    (answers.q * weights()).sum().backward()
    gradient = targets.grad.numpy()
    assert not gradient[:, 3].any()
    for j in range(6):
        step = 1e-4
        ends = []
        for sign in (1, -1):
            moved = poses.copy()
            if j < 3:
                moved[:, j, 3] += sign * step
            else:
                turn = ik.rotations.pose((0, 0, 0), axis_angle=sign * step * np.eye(3)[j - 3])
                moved[:, :3, :3] = turn[:3, :3] @ moved[:, :3, :3]
            found = agrik_fast.torch.ik(UR5, torch.tensor(moved), q0=NEAR, **TIGHT)
            ends.append((moved, (found.q * weights()).sum(-1).numpy()))
        (up, more), (down, less) = ends
        along = (gradient * (up - down)).sum((-1, -2)) / (2 * step)
        change = (more - less) / (2 * step)
        np.testing.assert_allclose(along, change, rtol=1e-6, atol=1e-6)


def test_gradients_of_points_pass_gradcheck() -> None:
    arm = ik.Robot.load("tomato")
    q = np.array([[0.2, 0.6, -0.7], [0.5, 0.4, -0.5]])
    q = np.clip(q, arm.lower + 0.2, arm.upper - 0.2)
    points = torch.tensor(arm.fk(q)[:, :3, 3], requires_grad=True)

    def solve(targets: Any) -> Any:
        return agrik_fast.torch.ik(arm, targets, q0=q, position_tolerance=1e-13).q

    assert solve(points).shape == (2, 3)
    assert torch.autograd.gradcheck(solve, (points,), eps=1e-5, atol=1e-6, rtol=1e-6)


def test_forward_kinematics_pass_gradcheck() -> None:
    q = torch.tensor(NEAR, requires_grad=True)
    assert torch.autograd.gradcheck(lambda q: agrik_fast.torch.fk(UR5, q), (q,), atol=1e-6)


def test_there_and_back_is_the_identity() -> None:
    """The gradient of q by q, through a pose."""
    q = torch.tensor(NEAR, requires_grad=True)
    back = agrik_fast.torch.ik(UR5, agrik_fast.torch.fk(UR5, q), q0=NEAR, **TIGHT).q
    (back * weights()).sum().backward()
    np.testing.assert_allclose(q.grad.numpy(), weights().numpy(), rtol=0, atol=1e-6)


def test_single_numbers_stay_single() -> None:
    targets = torch.tensor(UR5.fk(NEAR), dtype=torch.float32, requires_grad=True)
    answers = agrik_fast.torch.ik(UR5, targets, q0=NEAR)
    answers.q.sum().backward()
    assert answers.q.dtype == targets.grad.dtype == torch.float32


def test_wrong_arguments_are_said() -> None:
    for wrong, words in (
        (np.eye(4), "a torch.Tensor"),
        (torch.eye(4, dtype=torch.float16), "float32 or float64"),
        (torch.eye(4, device="meta"), "on the CPU"),
    ):
        with pytest.raises(ik.ArgumentError, match=words):
            agrik_fast.torch.ik(UR5, wrong)
    with pytest.raises(ik.ArgumentError, match="shape"):
        agrik_fast.torch.ik(UR5, torch.eye(3, 5))
