"""Inverse kinematics of a robot: every way to ask it for joint values."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Literal, Protocol, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, float_array, whole_number, word
from .._stream import solve_ahead
from ._path import Path

if TYPE_CHECKING:
    from .._native import Chain, Collider, TargetSolver
    from ..result import Branches, IkResult
    from ..solvers import DifferentialEvolution, GeneticAlgorithm, Solver
    from ..tasks import Task
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
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
        first_index: int = 0,
        scene: SceneOf | Collider | None = None,
        clear: float = 0.0,
        prefer: Prefer = "first",
    ) -> IkResult:
        """Inverse kinematics of a batch of targets.

        A target that cannot be solved is no error: its row of the result has
        ``success`` False, a status that says why, and the best joint values found.
        The same input, seed and version give bit-identical answers for any number of
        threads and for any split of a batch (see `first_index`).

        Parameters
        ----------
        targets : array_like, shape (..., 4, 4) or (..., 3)
            Poses of the tool, or positions of the tool point, in the base frame; m.
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
        tool : array_like, shape (4, 4), optional
            An offset behind the robot's own tool for this call: the transform from the
            robot's tool frame to the frame that has to reach the target, m.
        threads : int, optional
            Number of threads; default as set by `agrik_fast.set_num_threads` or the
            environment variable ``AGRIK_NUM_THREADS``, else one per core.
        position_tolerance : float, default 1e-6
            Largest distance between tool point and target, m; above 0.
        orientation_tolerance : float, default 1e-6
            Largest angle between tool and target orientation, rad; above 0.
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

        Returns
        -------
        IkResult
            Joint values, success, status, errors and effort, in the targets' leading
            shape; with a scene also clearances and what is nearest.

        Raises
        ------
        ArgumentError
            A wrong shape, type or value of an argument; a transform that is not rigid.
            Non-finite rows of `targets` or `q0` do not raise: their status is
            ``Status.BAD_INPUT``.
        UnknownNameError
            Unknown task or solver; names the nearest.
        KeyboardInterrupt
            Ctrl-C; a long batch stops within a second.
        """
        return self._chain.ik(
            targets,
            task,
            solver,
            q0,
            seed,
            tool,
            threads,
            position_tolerance,
            orientation_tolerance,
            first_index,
            _collider(self, scene),
            clear,
            word("prefer", prefer, PREFERENCES),
        )

    def solver(
        self,
        task: Task | str | None = None,
        solver: Solver | str = "lm",
        seed: int = 0,
        tool: ArrayLike | None = None,
        *,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
    ) -> TargetSolver:
        """Make a solver for one target at a time, for control loops.

        Options are read once; its `solve` gives, bit for bit, what `ik` gives for the same
        target, and allocates nothing after the first call.

        Parameters
        ----------
        task : task or {"position", "pose", "axis"}, default "pose"
            What counts as reached, see `agrik_fast.tasks`.
        solver, seed, tool, position_tolerance, orientation_tolerance
            As for `ik`; step solvers only.

        Returns
        -------
        TargetSolver
            With `solve(target, q0)` and the last answer as attributes.

        Raises
        ------
        ArgumentError
            As for `ik`.
        """
        return self._chain.solver(
            task, solver, seed, tool, position_tolerance, orientation_tolerance
        )

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
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
    ) -> Path:
        """Follow a sequence of targets, every posture the continuation of the one before.

        Each target is solved by the default step solver from the posture before, inside
        limits that leave every joint no more than one step. The freedom that a redundant
        arm has is used to stay near the posture before. If that fails, other postures
        within the step are tried; if none leads to the target, the nearest posture that a
        search of the whole range finds is taken and reported as a discontinuity.

        Parameters
        ----------
        targets : array_like, shape (n, 4, 4) or (n, 3)
            Poses of the tool, or positions of the tool point, in order, base frame; m.
        q0 : array_like, shape (dof,), rad or m, optional
            Where the arm stands before the first target, within the limits. Without it the
            first posture is free.
        max_joint_step : float or array_like, shape (dof,), rad or m, default 0.1
            Largest change of each joint from one target to the next.
        task, tool, position_tolerance, orientation_tolerance : optional
            As in `ik`.
        seed : int, default 0
            Seed of the searches, 0 to 2**64 - 1.
        pull : float, default 0.5
            Share of the way back to the posture before that each solver step goes in the
            null space of the task; 0 to 1.

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
        """
        result, jumps = self._chain.follow(
            targets,
            max_joint_step,
            q0,
            pull,
            task,
            seed,
            tool,
            position_tolerance,
            orientation_tolerance,
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
        """
        return self._chain.cost_history(target, solver, task, q0, seed, tool)

    @property
    def closed_form(self) -> str | None:
        """Family of the arm's closed form, "spherical wrist" or "S-R-S"; None without."""
        return self._chain.closed_form[0]

    def ik_all(
        self,
        targets: ArrayLike,
        q0: ArrayLike | None = None,
        tool: ArrayLike | None = None,
        threads: int | None = None,
        arm_angle: ArrayLike | None = None,
        *,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
        locked: Mapping[str, ArrayLike] | None = None,
    ) -> Branches:
        """Every branch of the inverse kinematics of an arm with a closed form.

        Six revolute joints of which the last three axes meet have up to eight branches;
        seven revolute joints of which also the first three meet (S-R-S) have up to eight
        for each arm angle. Each branch is checked by forward kinematics. An arm with more
        joints has the branches of what is left when some are locked, as one on a slide at
        each place of it.

        Parameters
        ----------
        targets : array_like, shape (..., 4, 4)
            Poses of the tool in the base frame; m.
        q0 : array_like, shape broadcastable to (..., n), rad, optional
            Of the values a whole turn apart that a joint's limits allow, the one nearest to
            this is returned, and angles that a singularity leaves open are taken from it.
            Default: the middle of the limits.
        tool : array_like, shape (4, 4), optional
            An offset behind the robot's own tool for this call, as for `ik`, m.
        threads : int, optional
            Number of threads, as for `ik`.
        arm_angle : array_like, shape broadcastable to (...), rad, optional
            Arm angle of an S-R-S arm, see `arm_angle`. Default: that of `q0`, or 0.
        position_tolerance : float, default 1e-6
            Largest distance between tool point and target, m; above 0. Branches of
            reachable targets come to rounding; this decides at the edge of the reach.
        orientation_tolerance : float, default 1e-6
            Largest angle between tool and target orientation, rad; above 0.
        locked : mapping of str to array_like, shape broadcastable to (...), optional
            Joints that are kept where they are, by name, and their values within the limits,
            rad or m: one for all targets, or one a target. What is left must have a closed
            form. A NaN makes its target ``BAD_INPUT``.

        Returns
        -------
        Branches
            Joint values (..., 8, n), which of them are valid, and a status per target:
            ``CONVERGED`` with at least one valid branch; ``OUT_OF_REACH`` if it is
            proven that none exists within limits and tolerances; ``NOT_FOUND`` if there is
            neither a branch nor a proof, or an S-R-S arm has a branch only at other arm
            angles.

        Raises
        ------
        ArgumentError
            The arm has no closed form (the message says why), or an argument is wrong, as
            a locked value outside the limits.
        UnknownNameError
            `locked` names a joint that the arm has not; the message names the nearest.
        KeyboardInterrupt
            Ctrl-C; a long batch stops within a second.

        Examples
        --------
        >>> import agrik_fast as ik
        >>> arm = ik.Robot.load("puma560")
        >>> branches = arm.ik_all(arm.fk([0.1, 0.6, -0.4, 0.3, 0.5, 0.2]))
        >>> branches.q.shape, int(branches.valid.sum())
        ((8, 6), 4)

        An arm on a slide, at one place of the slide:

        >>> arm = ik.Robot.load("cucumber")
        >>> pose = arm.fk([0.5, 0.1, -0.9, 0.3, 0.2, 0.4, 3.0])
        >>> branches = arm.ik_all(pose, locked={"d1": 0.5})
        >>> branches.q.shape, int(branches.reached.sum())
        ((8, 7), 4)
        """
        return self._chain.ik_all(
            targets,
            q0,
            tool,
            threads,
            arm_angle,
            position_tolerance,
            orientation_tolerance,
            locked,
        )

    def arm_angle(self, q: ArrayLike) -> FloatArray:
        """Arm angle of an S-R-S arm.

        The elbow's turn about the line from shoulder to wrist, by the right hand about the
        direction to the wrist. It is zero where the elbow leans towards the direction of
        the first axis (where the wrist is right above or below the shoulder: towards x of
        the base frame, or y if the first axis is along x).

        Parameters
        ----------
        q : array_like, shape (..., 7), rad
            Joint values.

        Returns
        -------
        ndarray, shape (...), rad
            Angles in [-pi, pi].

        Raises
        ------
        ArgumentError
            The arm is no S-R-S arm, or `q` has another last dimension.
        """
        return self._chain.arm_angle(q)

    def arm_angle_intervals(
        self, target: ArrayLike, tool: ArrayLike | None = None
    ) -> tuple[FloatArray, ...]:
        """Arm angles at which the limits allow a pose of an S-R-S arm, for each branch.

        Parameters
        ----------
        target : array_like, shape (4, 4)
            Pose of the tool in the base frame; m.
        tool : array_like, shape (4, 4), optional
            An offset behind the robot's own tool for this call, as for `ik`, m.

        Returns
        -------
        tuple of 8 ndarray, shape (k, 2), rad
            First and last arm angle of each interval, in the order of the branches of
            `ik_all`; the first in [-pi, pi), the last above pi where the interval goes
            through half a turn. No rows for a branch without any.

        Raises
        ------
        ArgumentError
            The arm is no S-R-S arm, or the target is no rigid transform.
        """
        found = self._chain.arm_angle_intervals(target, tool)
        return tuple(np.array(one, dtype=np.float64).reshape(-1, 2) for one in found)

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
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
        first_index: int = 0,
        scene: SceneOf | Collider | None = None,
        clear: float = 0.0,
        prefer: Prefer = "first",
    ) -> Iterator[IkResult]:
        """Inverse kinematics of a stream of chunks, for more targets than memory holds.

        One chunk is solved ahead: while the caller uses a result, the next chunk is being
        solved in another thread. The answers are those of one call of `ik` with all
        targets. Chunks are taken from the iterator in the caller's thread.

        Parameters
        ----------
        chunks : iterable of array_like, each of shape (..., 4, 4) or (..., 3)
            Targets as for `ik`; some tens of thousands in a chunk keep all cores busy.
        task, solver, seed, tool, threads, position_tolerance, orientation_tolerance, scene, \
        clear, prefer
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
                first_index=index,
                scene=handle,
                clear=clear,
                prefer=prefer,
            )

        return solve_ahead(chunks, solve, first_index)


def _collider(arm: InverseKinematics, scene: SceneOf | Collider | None) -> Collider | None:
    """Return what a scene is to the compiled core: the arm's bodies in it."""
    make = getattr(scene, "collider", None)
    return cast("Collider | None", scene if make is None else make(arm))
