"""Inverse kinematics of a robot: every way to ask it for joint values."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Literal, Protocol, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from .._checks import (
    FloatArray,
    float_array,
    frame_of,
    real_number,
    shown,
    whole_number,
    word,
)
from .._stream import solve_ahead
from ..errors import ArgumentError
from ._limits import JointLimits, in_the_core, limits_of_rows, with_limits_of_rows
from ._many import in_base
from ._path import Path
from ._targets import INVALID, Invalid, Order, as_targets

if TYPE_CHECKING:
    from .._native import Chain, Collider, TargetSolver
    from ..result import IkResult
    from ..solvers import DifferentialEvolution, GeneticAlgorithm, Solver
    from ..tasks import SecondAim, Task
    from . import Robot

__all__ = ["InverseKinematics"]


Prefer: TypeAlias = Literal["first", "near", "clearance"]
"""Which of several postures that are free of collisions."""

PREFERENCES: tuple[Prefer, ...] = ("first", "near", "clearance")
"""All of them."""


class SceneOf(Protocol):
    """What has a collider for an arm: `agrik_fast.collision.Scene`, which stands above here."""

    def collider(self, arm: Robot, /) -> Collider:
        """Return the arm's bodies in the scene."""


class InverseKinematics:
    """The part of `Robot` that finds joint values for poses and positions."""

    __slots__ = ()

    _chain: Chain

    def ik(
        self,
        targets: ArrayLike,
        task: Task | str | None = None,
        solver: Solver | str = "lm",
        q0: ArrayLike | None = None,
        seed: int = 0,
        tool: ArrayLike | None = None,
        threads: int | None = None,
        *,
        position_tolerance: ArrayLike = 1e-6,
        orientation_tolerance: ArrayLike = 1e-6,
        tolerance_frame: Literal["base", "tool"] | None = None,
        first_index: int = 0,
        scene: SceneOf | Collider | None = None,
        clear: float = 0.0,
        prefer: Prefer = "first",
        invalid: Invalid = "mark",
        second_aim: SecondAim | str | None = None,
        nearest: bool | int = False,
        joint_weights: ArrayLike | None = None,
        limits: ArrayLike | None = None,
        base: ArrayLike | None = None,
        order: Order | None = None,
    ) -> IkResult:
        """Inverse kinematics of a batch of targets.

        A target that cannot be solved is no error: its row of the result has
        ``success`` False, a status that says why, and the best joint values found.
        The same input, seed and version give bit-identical answers for any number of
        threads and for any split of a batch (see `first_index`).

        Parameters
        ----------
        targets : array_like, shape (..., 4, 4), (..., 3) or (..., 7)
            Poses of the tool, or positions of the tool point, in the base frame; m. Rows of
            seven numbers are poses in an `order`. So are poses of SciPy (`RigidTransform`, or a
            pair of places and `Rotation`), spatialmath and Pinocchio (`SE3`), one or a list, and
            arrays of libraries with DLPack or ``__array__`` (torch, JAX) on the CPU.
        task : task or {"position", "pose", "axis"}, optional
            What counts as reached, see `agrik_fast.tasks`. Default: "pose" for shape
            (..., 4, 4), "position" for (..., 3).
        solver : solver or a name, default "lm"
            How to get there, see `agrik_fast.solvers`; names are "lm", "dls", "pinv",
            "pinv-closed", "transpose", "ccd", "ik-pid", "state-space", "static-gain",
            "broyden", "de", "ga", "closed_form" (full poses of arms that have one, see
            `closed_form`) and "auto", the closed form where there is one, else "lm".
        q0 : array_like, shape broadcastable to (..., n), rad or m, optional
            Start values of the first attempt. Default: chosen from the seed.
        seed : int, default 0
            Seed of the random start values, 0 to 2**64 - 1.
        tool : array_like, shape (4, 4) or (3,), optional
            An offset behind the robot's own tool for this call: the transform from the
            robot's tool frame to the frame that has to reach the target, m, or the place of
            that frame alone, which does not turn it.
        threads : int, optional
            Number of threads; default as set by `agrik_fast.set_num_threads` or the
            environment variable ``AGRIK_NUM_THREADS``, else one per core.
        position_tolerance : float or array_like, shape (3,), m, default 1e-6
            Largest distance between tool point and target, or largest error along each of
            x, y, z; above 0. ``inf`` leaves an axis free.
        orientation_tolerance : float or array_like, shape (3,), rad, default 1e-6
            Largest angle between tool and target orientation, or largest error about each
            of x, y, z (entries of the rotation vector from tool to target); above 0.
            ``inf`` leaves an axis free.
        tolerance_frame : {"base", "tool"}, optional
            Whose axes the three numbers of a tolerance are for: those of the base, or of
            the tool as it stands. Default: those of a `Masked` task, else of the base.
        first_index : int, default 0
            Index of the first target within a larger batch, so that the pieces of a
            batch get the answers of the whole.
        scene : Scene, optional
            What answers must not hit, see `agrik_fast.collision`; the arm needs bodies. Among
            the branches, restarts and free angles of a target one is looked for at which the
            arm hits neither the scene nor itself. Where all that reach the target hit, the
            status is ``IN_COLLISION``, with the least bad posture; ``nearest_pair`` of the
            result says what hits what.
        clear : float, default 0, m
            Distance that answers keep from the scene, more than which it has to be; of pairs
            of the arm's own bodies it is 0.
        prefer : {"first", "near", "clearance"}, default "first"
            Which of several free postures: the first one found (of a closed form the best by
            its own choice), the nearest to `q0` (without it to the middle of the limits), or
            the one farthest away from everything, which a redundant arm then moves farther
            away. The last two look at more postures, and take longer.
        invalid : {"mark", "raise", "straighten"}, default "mark"
            What becomes of poses that are no rigid transforms. "mark": those that rounding to
            three or more decimals explains are straightened, with ``Warnings.STRAIGHTENED`` in
            ``warnings``; the others are ``Status.BAD_INPUT``. "straighten": also what is off by
            up to two per cent, as for `agrik_fast.rotations.straighten`. "raise": an error.
        second_aim : SecondAim or {"near", "middle", "limits", "manipulability"}, optional
            What the freedom that a target leaves is used for, see `agrik_fast.tasks.SecondAim`:
            answers are moved to a local optimum and stay answers. Without one, and without
            `q0`, answers of step solvers only keep off limits at which they need not stand.
        nearest : bool or int, default False
            Of all solutions the one with the least weighted sum of squared changes from `q0`,
            which is needed. Of arms whose branches `ik_all` finds without a lock, of all of
            them. Of arms with one joint to spare that `ik_all` sweeps, from the branches at 64
            values of the free quantity: those nearer than their neighbours are moved to where
            they are nearest. Of others from 32 starts, each moved likewise; a number asks for so
            many starts, of any arm with joints to spare. ``restarts`` counts what was moved.
        joint_weights : array_like, shape (n,), optional
            What the change of each joint counts for `nearest`, 0 or more; default 1 each.
        limits : array_like, shape (n, 2) or broadcastable to (..., n, 2), rad or m, optional
            Smallest and largest joint values of this call, or of each target, in place of the
            robot's; NaN keeps the robot's. A row whose lower limit is above the upper one is
            ``Status.BAD_INPUT``. Those of each target cost little with "lm", "dls", "pinv",
            "pinv-closed" and "transpose", and about a millisecond a target with others, with
            `second_aim`, `nearest` or in a scene.
        base : array_like, shape broadcastable to (..., 4, 4), optional
            Where the arm's base stands for each target, in place of `Robot.base`, m.
        order : {"xyz_xyzw", "xyz_wxyz", "xyzw_xyz", "wxyz_xyz"}, optional
            Order of the numbers of targets of shape (..., 7): place, m, and unit quaternion.
            Those whose length is off by less than 0.001 (for "straighten" 0.02) are rounded.

        Returns
        -------
        IkResult
            Joint values, success, status, errors and effort, in the targets' leading
            shape; with a scene also clearances and what is nearest.

        Raises
        ------
        ArgumentError
            A wrong shape, type or value of an argument; with ``invalid="raise"`` a transform
            that is not rigid. Non-finite rows of `targets` or `q0` do not raise: their status is
            ``Status.BAD_INPUT``.
        UnknownNameError
            Unknown task or solver; names the nearest.
        KeyboardInterrupt
            Ctrl-C; a long batch stops within a second.

        Examples
        --------
        A gripper that may turn freely about its own z axis, and by 5 degrees about the others:

        >>> from agrik_fast import Robot
        >>> robot = Robot.load("puma560")
        >>> pose = robot.fk([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
        >>> bool(
        ...     robot.ik(
        ...         pose,
        ...         orientation_tolerance=(0.087, 0.087, float("inf")),
        ...         tolerance_frame="tool",
        ...     ).success
        ... )
        True
        """
        if order is not None or type(targets) is not np.ndarray:
            targets = as_targets(targets, order, word("invalid", invalid, INVALID))
        if base is not None:
            targets = in_base(self._chain.base, targets, base)
        each: FloatArray | None = None
        table, rows = None, None
        if limits is not None:
            table, rows = limits_of_rows(cast(JointLimits, self), targets, limits)
            if rows is not None and in_the_core(solver, scene, second_aim, nearest):
                each = table
        if table is not None and each is None:
            return with_limits_of_rows(
                InverseKinematics.ik,
                cast(JointLimits, self),
                targets,
                table,
                rows,
                task=task,
                solver=solver,
                q0=q0,
                seed=seed,
                tool=tool,
                threads=threads,
                position_tolerance=position_tolerance,
                orientation_tolerance=orientation_tolerance,
                tolerance_frame=tolerance_frame,
                first_index=first_index,
                scene=scene,
                clear=clear,
                prefer=prefer,
                invalid=invalid,
                second_aim=second_aim,
                nearest=nearest,
                joint_weights=joint_weights,
            )
        return self._chain.ik(
            targets,
            task,
            solver,
            q0,
            seed,
            tool if tool is None else frame_of("tool", tool),
            threads,
            position_tolerance,
            orientation_tolerance,
            first_index,
            tolerance_frame,
            None if scene is None else _collider(self, scene),
            clear,
            prefer,
            invalid,
            second_aim,
            nearest,
            joint_weights,
            each,
        )

    def solver(
        self,
        task: Task | str | None = None,
        solver: Solver | str = "lm",
        seed: int = 0,
        tool: ArrayLike | None = None,
        *,
        position_tolerance: ArrayLike = 1e-6,
        orientation_tolerance: ArrayLike = 1e-6,
        tolerance_frame: Literal["base", "tool"] | None = None,
        second_aim: SecondAim | str | None = None,
        max_change: ArrayLike | None = None,
        rate_hz: float | None = None,
    ) -> TargetSolver:
        """Make a solver for one target at a time, for control loops.

        Options are read once; its `solve` gives, bit for bit, what `ik` gives for the same
        target, and allocates nothing after the first call. With `max_change` each call is a
        tick of a loop instead: the posture goes on from the one before and never jumps.

        Parameters
        ----------
        task : task or {"position", "pose", "axis"}, default "pose"
            What counts as reached, see `agrik_fast.tasks`.
        solver, seed, tool, position_tolerance, orientation_tolerance, tolerance_frame
            As for `ik`; step solvers only.
        second_aim : SecondAim or {"near", "middle", "limits", "manipulability"}, optional
            As for `ik`; with `max_change` as far as each tick's bound allows.
        max_change : float or array_like, shape (n,), rad or m, optional
            Largest change of each joint from call to call, above 0: from `q0` of the call, or
            without it from the answer before. A target that is not reached within the bound has
            the status ``HELD``: the posture goes to the nearest one that reaches it, or, out of
            reach, that comes nearest to it, first by place, then by orientation. Without `q0`
            the first call is free, as `ik` is.
        rate_hz : float, 1/s, optional
            Calls a second, in place of `max_change`: a joint changes by no more than its
            `velocity_limits` allow between two calls.

        Returns
        -------
        TargetSolver
            With `solve(target, q0)` and the last answer as attributes.

        Raises
        ------
        ArgumentError
            As for `ik`; a `max_change` or `rate_hz` that is not above 0, both of them, or
            `rate_hz` for a robot without velocity limits.

        Examples
        --------
        A target that jumps by half a metre out of reach, and the arm that stretches towards it:

        >>> from agrik_fast import Robot, Status
        >>> arm = Robot.load("panda")
        >>> q = arm.home + 0.2
        >>> loop = arm.solver(max_change=0.01)
        >>> target = arm.fk(q)
        >>> target[:3, 3] += [1.0, 0.0, 0.0]
        >>> loop.solve(target, q)
        False
        >>> Status(loop.status).name, bool(abs(loop.q - q).max() <= 0.01)
        ('HELD', True)
        """
        tolerances = (position_tolerance, orientation_tolerance, tolerance_frame)
        if rate_hz is not None:
            if max_change is not None:
                raise ArgumentError("rate_hz", shown(rate_hz), "none beside max_change")
            max_change = self._change_of_a_call(real_number("rate_hz", rate_hz, 0, open_low=True))
        recipe = (_solver, (self, task, solver, seed, tool, *tolerances, second_aim, max_change))
        offset = tool if tool is None else frame_of("tool", tool)
        return self._chain.solver(
            task, solver, seed, offset, *tolerances, second_aim, max_change, recipe
        )

    def _change_of_a_call(self, rate_hz: float) -> FloatArray:
        """Return what velocity limits allow from call to call."""
        fastest: FloatArray = self._chain.motion_limits[0]
        if not np.isfinite(fastest).all():
            joint = self._chain.joint_names[int(np.argmin(np.isfinite(fastest)))]
            expected = "a robot with velocity limits, such as arm.with_motion_limits(velocity=1)"
            raise ArgumentError("rate_hz", f"no velocity limit of joint {joint!r}", expected)
        return fastest / rate_hz

    def follow(
        self,
        targets: ArrayLike,
        q0: ArrayLike | None = None,
        max_joint_step: ArrayLike = 0.1,
        task: Task | str | None = None,
        seed: int = 0,
        tool: ArrayLike | None = None,
        *,
        pull: float = 0.5,
        position_tolerance: ArrayLike = 1e-6,
        orientation_tolerance: ArrayLike = 1e-6,
        tolerance_frame: Literal["base", "tool"] | None = None,
        order: Order | None = None,
    ) -> Path:
        """Follow a sequence of targets, every posture the continuation of the one before.

        Each target is solved by the default step solver from the posture before, inside
        limits that leave every joint no more than one step. The freedom that a redundant
        arm has is used to stay near the posture before. If that fails, other postures
        within the step are tried. Where the way from the target before goes on, but needs more
        than a step, it is taken: ``speed`` says by how much it is too fast. Before that a
        front of up to 32 postures goes the same way from some targets before, without `q0`
        also from up to 32 postures of the first target: so the start is the one whose path
        holds. If none does, the nearest posture that a search of the whole range finds is
        taken and reported as a discontinuity.

        Parameters
        ----------
        targets : array_like, shape (n, 4, 4), (n, 3) or (n, 7)
            Poses of the tool, or positions of the tool point, one after the other, base frame;
            m. Of any kind that `ik` takes.
        q0 : array_like, shape (dof,), rad or m, optional
            Where the arm stands before the first target, within the limits or outside by no
            more than 1e-3. The first posture is the nearest to it that is found, however far.
            Without it the first posture is free.
        max_joint_step : float or array_like, shape (dof,), rad or m, default 0.1
            Largest change of each joint from one target to the next.
        task, tool, position_tolerance, orientation_tolerance, tolerance_frame : optional
            As in `ik`.
        seed : int, default 0
            Seed of the searches, 0 to 2**64 - 1.
        pull : float, default 0.5
            Share of the way back to the posture before that each solver step goes in the
            null space of the task; 0 to 1.
        order : str, optional
            Of targets of shape (n, 7), as for `ik`.

        Returns
        -------
        Path
            Joint values, success, errors and discontinuities, one row a target.

        Raises
        ------
        ArgumentError
            A wrong shape, type or value of an argument; start values out of the limits.
        KeyboardInterrupt
            Ctrl-C.

        Examples
        --------
        >>> arm = ik.Robot.load("ur5")
        >>> q = np.radians([30.0, -100.0, 110.0, -100.0, -90.0, 0.0])
        >>> line = np.repeat(arm.fk(q)[None], 11, axis=0)
        >>> line[:, 0, 3] += np.linspace(0.0, 0.05, 11)
        >>> arm.follow(line, q, max_joint_step=0.05)
        Path(11 targets: 11 reached, 0 discontinuities)
        """
        if order is not None or type(targets) is not np.ndarray:
            targets = as_targets(targets, order, "mark")
        result, jumps, speed = self._chain.follow(
            targets,
            max_joint_step,
            q0,
            pull,
            task,
            seed,
            tool if tool is None else frame_of("tool", tool),
            position_tolerance,
            orientation_tolerance,
            tolerance_frame,
        )
        steps = np.zeros_like(result.q)
        if len(steps):
            steps[1:] = np.diff(result.q, axis=0)
            if q0 is not None:
                steps[0] = result.q[0] - float_array("q0", q0)
        return Path(
            q=result.q,
            success=result.success,
            status=result.status,
            position_error=result.position_error,
            orientation_error=result.orientation_error,
            iterations=result.iterations,
            discontinuity=jumps,
            joint_step=steps,
            speed=speed,
        )

    def cost_history(
        self,
        target: ArrayLike,
        solver: DifferentialEvolution | GeneticAlgorithm | str = "de",
        task: Task | str | None = None,
        q0: ArrayLike | None = None,
        seed: int = 0,
        tool: ArrayLike | None = None,
    ) -> FloatArray:
        """Best cost of a population solver, generation by generation.

        Parameters
        ----------
        target : array_like, shape (4, 4) or (3,)
            Pose of the tool, or position of the tool point, in the base frame; m.
        solver : DifferentialEvolution, GeneticAlgorithm, "de" or "ga"
            The search.
        task, q0, seed, tool : optional
            As in `ik`.

        Returns
        -------
        ndarray, shape (generations + 1,)
            Cost of the best individual of the first population and after each generation
            of the first run of `ik` with the same arguments; weights of the solver.

        Raises
        ------
        ArgumentError
            A step solver, several targets, or a wrong argument as in `ik`.

        Examples
        --------
        >>> arm = ik.Robot.load("ur5")
        >>> history = arm.cost_history([0.4, 0.2, 0.3], "de", seed=1)
        >>> bool(history[-1] < history[0])
        True
        """
        offset = tool if tool is None else frame_of("tool", tool)
        return self._chain.cost_history(target, solver, task, q0, seed, offset)

    def ik_stream(
        self,
        chunks: Iterable[ArrayLike],
        task: Task | str | None = None,
        solver: Solver | str = "lm",
        q0: ArrayLike | None = None,
        seed: int = 0,
        tool: ArrayLike | None = None,
        threads: int | None = None,
        *,
        position_tolerance: ArrayLike = 1e-6,
        orientation_tolerance: ArrayLike = 1e-6,
        tolerance_frame: Literal["base", "tool"] | None = None,
        first_index: int = 0,
        scene: SceneOf | Collider | None = None,
        clear: float = 0.0,
        prefer: Prefer = "first",
        invalid: Invalid = "mark",
        second_aim: SecondAim | str | None = None,
        nearest: bool | int = False,
        joint_weights: ArrayLike | None = None,
        order: Order | None = None,
    ) -> Iterator[IkResult]:
        """Inverse kinematics of a stream of chunks, for more targets than memory holds.

        One chunk is solved ahead: while the caller uses a result, the next chunk is being
        solved in another thread. The answers are those of one call of `ik` with all
        targets. Chunks are taken from the iterator in the caller's thread.

        Parameters
        ----------
        chunks : iterable of array_like, each of shape (..., 4, 4), (..., 3) or (..., 7)
            Targets as for `ik`; some tens of thousands in a chunk keep all cores busy.
        task, solver, seed, tool, threads, scene, clear, prefer, invalid, order : optional
            As for `ik`, the same for all chunks.
        second_aim, nearest, joint_weights : optional
            As for `ik`, the same for all chunks.
        position_tolerance, orientation_tolerance, tolerance_frame : optional
            As for `ik`, the same for all chunks.
        q0 : array_like, shape (n,), rad or m, optional
            Start values of every target's first attempt.
        first_index : int, default 0
            Index of the first target of the first chunk; those that follow are counted on.

        Returns
        -------
        iterator of IkResult
            One result a chunk, in order.

        Raises
        ------
        ArgumentError, UnknownNameError
            As `ik`, when the chunk's result is asked for; `first_index` at once.

        Examples
        --------
        >>> arm = ik.Robot.load("ur5")
        >>> chunks = (arm.fk(arm.random_q(100, seed=k)) for k in range(3))
        >>> sum(int(part.success.sum()) for part in arm.ik_stream(chunks))
        300
        """
        first_index = whole_number("first_index", first_index, 0, 2**64 - 1)
        handle = _collider(self, scene)

        def solve(targets: ArrayLike, index: int) -> IkResult:
            return self.ik(
                targets,
                task,
                solver,
                q0,
                seed,
                tool,
                threads,
                position_tolerance=position_tolerance,
                orientation_tolerance=orientation_tolerance,
                tolerance_frame=tolerance_frame,
                first_index=index,
                scene=handle,
                clear=clear,
                prefer=prefer,
                invalid=invalid,
                second_aim=second_aim,
                nearest=nearest,
                joint_weights=joint_weights,
                order=order,
            )

        return solve_ahead(chunks, solve, first_index)


def _collider(arm: InverseKinematics, scene: SceneOf | Collider | None) -> Collider | None:
    """Return what a scene is to the compiled core: the arm's bodies in it."""
    make = getattr(scene, "collider", None)
    return cast("Collider | None", scene if make is None else make(arm))


def _solver(
    robot: InverseKinematics,
    task: Task | str | None,
    solver: Solver | str,
    seed: int,
    tool: ArrayLike | None,
    position_tolerance: ArrayLike,
    orientation_tolerance: ArrayLike,
    tolerance_frame: Literal["base", "tool"] | None,
    second_aim: SecondAim | str | None = None,
    max_change: ArrayLike | None = None,
) -> TargetSolver:
    """Make a solver again, as its pickle says."""
    return robot.solver(
        task,
        solver,
        seed,
        tool,
        position_tolerance=position_tolerance,
        orientation_tolerance=orientation_tolerance,
        tolerance_frame=tolerance_frame,
        second_aim=second_aim,
        max_change=max_change,
    )
