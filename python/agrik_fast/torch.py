"""Inverse and forward kinematics inside PyTorch graphs, on the CPU.

Needs the extra ``torch``. Gradients pass from joint values to targets by the implicit function
theorem (`IkResult.jacobian_of_q`), not through the solver's steps.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from . import _gradients
from ._checks import shown
from .errors import ArgumentError, MissingExtraError

try:
    import torch
except ImportError:
    raise MissingExtraError("agrik_fast.torch", "torch") from None

if TYPE_CHECKING:
    from .robot import Robot

__all__ = ["Solved", "fk", "ik"]


class Solved(NamedTuple):
    """Answers as tensors.

    Attributes
    ----------
    q : Tensor, shape (..., n), rad or m
        Joint values, in the targets' type of number; gradients pass through them. The gradients
        of targets that were not reached are 0.
    success : Tensor of bool, shape (...)
    status : Tensor of uint8, shape (...)
        Codes of `agrik_fast.Status`.

    Examples
    --------
    >>> import torch
    >>> import agrik_fast.torch
    >>> found = agrik_fast.torch.ik(ik.Robot.load("ur5"), torch.tensor([[0.4, 0.2, 0.3]]))
    >>> tuple(found.q.shape), found.success.tolist()
    ((1, 6), [True])
    """

    q: Any
    success: Any
    status: Any


def ik(robot: Robot, targets: Any, **options: Any) -> Solved:
    """Inverse kinematics of a tensor of targets, with gradients.

    Parameters
    ----------
    robot : Robot
        The arm.
    targets : Tensor, shape (..., 4, 4) or (..., 3)
        Poses of the tool, or positions of the tool point, in the base frame; m; on the CPU,
        float32 or float64.
    **options
        As for `Robot.ik`: task, solver, q0, seed, tool, threads, tolerances, scene, ...

    Returns
    -------
    Solved
        Joint values and how the search ended.

    Raises
    ------
    ArgumentError
        Targets that are no tensor of such numbers on the CPU; else as `Robot.ik`.

    Examples
    --------
    >>> import torch
    >>> import agrik_fast.torch
    >>> arm = ik.Robot.load("ur5")
    >>> target = torch.tensor([0.4, 0.2, 0.3], dtype=torch.float64, requires_grad=True)
    >>> agrik_fast.torch.ik(arm, target).q.sum().backward()
    >>> tuple(target.grad.shape)
    (3,)
    """
    _check("targets", targets)
    q, success, status = _Ik.apply(targets, robot, options)
    return Solved(q, success, status)


def fk(robot: Robot, q: Any) -> Any:
    """Forward kinematics of a tensor of joint values, with gradients.

    Parameters
    ----------
    robot : Robot
        The arm.
    q : Tensor, shape (..., n), rad or m
        Joint values; on the CPU, float32 or float64.

    Returns
    -------
    Tensor, shape (..., 4, 4)
        Poses of the tool in the base frame; lengths in m.

    Raises
    ------
    ArgumentError
        As for `ik`, and as `Robot.fk`.

    Examples
    --------
    >>> import torch
    >>> import agrik_fast.torch
    >>> q = torch.zeros(6, dtype=torch.float64, requires_grad=True)
    >>> agrik_fast.torch.fk(ik.Robot.load("ur5"), q)[:3, 3].sum().backward()
    >>> tuple(q.grad.shape)
    (6,)
    """
    _check("q", q)
    return _Fk.apply(q, robot)


def _check(argument: str, tensor: Any) -> None:
    if not isinstance(tensor, torch.Tensor):
        raise ArgumentError(argument, shown(type(tensor).__name__), "a torch.Tensor")
    if tensor.device.type != "cpu":
        raise ArgumentError(argument, f"a tensor on {tensor.device}", "one on the CPU: .cpu()")
    if tensor.dtype not in (torch.float32, torch.float64):
        raise ArgumentError(argument, f"numbers of {tensor.dtype}", "float32 or float64")


def _doubles(tensor: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.from_dlpack(tensor.detach().contiguous()).astype(np.float64)


def _tensor(array: Any, like: Any) -> Any:
    return torch.from_numpy(np.ascontiguousarray(array)).to(like.dtype)


class _Ik(torch.autograd.Function):  # type: ignore[misc,unused-ignore]
    @staticmethod
    def forward(ctx: Any, targets: Any, robot: Any, options: dict[str, Any]) -> Any:
        numbers = _doubles(targets)
        if ctx.needs_input_grad[0]:
            result, follows = _gradients.solved(robot, numbers, options)
            ctx.targets, ctx.follows = numbers, follows
        else:
            result = robot.ik(numbers, **options)
        success = torch.from_numpy(np.array(result.success))
        status = torch.from_numpy(np.array(result.status))
        ctx.mark_non_differentiable(success, status)
        return _tensor(result.q, targets), success, status

    @staticmethod
    def backward(ctx: Any, gradient: Any, *_: Any) -> Any:
        made = _gradients.to_targets(ctx.targets, ctx.follows, _doubles(gradient), np)
        return _tensor(made, gradient), None, None


class _Fk(torch.autograd.Function):  # type: ignore[misc,unused-ignore]
    @staticmethod
    def forward(ctx: Any, q: Any, robot: Any) -> Any:
        numbers = _doubles(q)
        poses = robot.fk(numbers)
        ctx.q, ctx.poses, ctx.robot = numbers, poses, robot
        return _tensor(poses, q)

    @staticmethod
    def backward(ctx: Any, gradient: Any) -> Any:
        made = _gradients.to_joints(ctx.robot, ctx.q, ctx.poses, _doubles(gradient))
        return _tensor(made, gradient), None
