"""Inverse and forward kinematics inside JAX programs, on the CPU.

Needs the extra ``jax``. Works under ``jax.jit`` and ``jax.vmap``, and has reverse-mode gradients
(``jax.grad``, ``jax.vjp``) by the implicit function theorem (`IkResult.jacobian_of_q`). JAX counts
in float32 unless ``jax_enable_x64`` is set; the solver itself always counts in float64.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from . import _gradients
from .errors import ArgumentError, MissingExtraError

try:
    import jax
    from jax import numpy as jnp
except ImportError:
    raise MissingExtraError("agrik_fast.jax", "jax") from None

if TYPE_CHECKING:
    from .robot import Robot

__all__ = ["Solved", "fk", "ik"]


class Solved(NamedTuple):
    """Answers as arrays of JAX.

    Attributes
    ----------
    q : Array, shape (..., n), rad or m
        Joint values, in the targets' type of number; gradients pass through them. The gradients
        of targets that were not reached are 0.
    success : Array of bool, shape (...)
    status : Array of uint8, shape (...)
        Codes of `agrik_fast.Status`.

    Examples
    --------
    >>> import agrik_fast.jax
    >>> found = agrik_fast.jax.ik(ik.Robot.load("ur5"), np.array([[0.4, 0.2, 0.3]]))
    >>> found.q.shape, found.success.tolist()
    ((1, 6), [True])
    """

    q: Any
    success: Any
    status: Any


def ik(robot: Robot, targets: Any, **options: Any) -> Solved:
    """Inverse kinematics of an array of targets, with gradients.

    Parameters
    ----------
    robot : Robot
        The arm.
    targets : array, shape (..., 4, 4) or (..., 3)
        Poses of the tool, or positions of the tool point, in the base frame; m.
    **options
        As for `Robot.ik`, the same for all calls of a compiled program: task, solver, q0, seed,
        tool, threads, tolerances, scene, ...

    Returns
    -------
    Solved
        Joint values and how the search ended.

    Raises
    ------
    ArgumentError
        Targets of another shape. What else `Robot.ik` refuses ends the program with JAX's own
        error, which holds the words of ours.

    Examples
    --------
    >>> import jax
    >>> import agrik_fast.jax
    >>> arm = ik.Robot.load("ur5")
    >>> follow = jax.grad(lambda point: agrik_fast.jax.ik(arm, point).q.sum())
    >>> follow(np.array([0.4, 0.2, 0.3])).shape
    (3,)
    """
    targets = _floats(targets)
    if targets.shape[-2:] != (4, 4) and targets.shape[-1:] != (3,):
        expected = "shape (..., 4, 4) for poses or (..., 3) for positions"
        raise ArgumentError("targets", f"shape {targets.shape}", expected)
    return Solved(*_ik(robot, _Options(options), targets))


def fk(robot: Robot, q: Any) -> Any:
    """Forward kinematics of an array of joint values, with gradients.

    Parameters
    ----------
    robot : Robot
        The arm.
    q : array, shape (..., n), rad or m
        Joint values.

    Returns
    -------
    Array, shape (..., 4, 4)
        Poses of the tool in the base frame; lengths in m.

    Raises
    ------
    ArgumentError
        Joint values of another shape.

    Examples
    --------
    >>> import jax
    >>> import agrik_fast.jax
    >>> arm = ik.Robot.load("ur5")
    >>> jax.grad(lambda q: agrik_fast.jax.fk(arm, q)[:3, 3].sum())(np.zeros(6)).shape
    (6,)
    """
    q = _floats(q)
    if q.shape[-1:] != (robot.dof,):
        raise ArgumentError("q", f"shape {q.shape}", f"shape (..., {robot.dof})")
    return _fk(robot, q)


class _Options:
    """Arguments of a call, which JAX hashes by who they are."""

    def __init__(self, given: dict[str, Any]) -> None:
        self.given = given


def _floats(array: Any) -> Any:
    array = jnp.asarray(array)
    return array if jnp.issubdtype(array.dtype, jnp.floating) else array.astype(float)


def _call(function: Any, shapes: Any, *arrays: Any) -> Any:
    # The whole of a `vmap` is one call, whose leading shape is broadcast.
    return jax.pure_callback(function, shapes, *arrays, vmap_method="broadcast_all")


@partial(jax.custom_vjp, nondiff_argnums=(0, 1))
def _ik(robot: Any, options: _Options, targets: Any) -> Any:
    def solve(numbers: Any) -> Any:
        result = robot.ik(_gradients.as_doubles(numbers), **options.given)
        return result.q.astype(numbers.dtype), result.success, result.status

    return _call(solve, _answers(robot, targets), targets)


def _answers(robot: Any, targets: Any) -> Any:
    leading = targets.shape[:-1] if targets.shape[-1] == 3 else targets.shape[:-2]
    return (
        jax.ShapeDtypeStruct((*leading, robot.dof), targets.dtype),
        jax.ShapeDtypeStruct(leading, np.bool_),
        jax.ShapeDtypeStruct(leading, np.uint8),
    )


def _ik_forward(robot: Any, options: _Options, targets: Any) -> Any:
    def solve(numbers: Any) -> Any:
        result, follows = _gradients.solved(robot, _gradients.as_doubles(numbers), options.given)
        kind = numbers.dtype
        return result.q.astype(kind), result.success, result.status, follows.astype(kind)

    answers = _answers(robot, targets)
    by = 3 if targets.shape[-1] == 3 else 6
    follows = jax.ShapeDtypeStruct((*answers[0].shape, by), targets.dtype)
    *answers, follows = _call(solve, (*answers, follows), targets)
    return tuple(answers), (targets, follows)


def _ik_backward(robot: Any, options: _Options, kept: Any, gradients: Any) -> Any:
    targets, follows = kept
    return (_gradients.to_targets(targets, follows, gradients[0], jnp),)


_ik.defvjp(_ik_forward, _ik_backward)


@partial(jax.custom_vjp, nondiff_argnums=(0,))
def _fk(robot: Any, q: Any) -> Any:
    def poses(numbers: Any) -> Any:
        return robot.fk(_gradients.as_doubles(numbers)).astype(numbers.dtype)

    return _call(poses, jax.ShapeDtypeStruct((*q.shape[:-1], 4, 4), q.dtype), q)


def _fk_forward(robot: Any, q: Any) -> Any:
    poses = _fk(robot, q)
    return poses, (q, poses)


def _fk_backward(robot: Any, kept: Any, gradient: Any) -> Any:
    q, poses = kept

    def back(q: Any, poses: Any, gradient: Any) -> Any:
        doubles = map(_gradients.as_doubles, (q, poses, gradient))
        return _gradients.to_joints(robot, *doubles).astype(q.dtype)

    return (_call(back, jax.ShapeDtypeStruct(q.shape, q.dtype), q, poses, gradient),)


_fk.defvjp(_fk_forward, _fk_backward)
