"""A robot as a table of its joints, and as the tables of its file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .. import _tables

if TYPE_CHECKING:
    from .._checks import FloatArray
    from .._native import Chain
    from ._definition import Definition

__all__ = ["JointTable"]


class JointTable(_tables.Tabular):
    """What a robot shows of itself in tables: a row a joint."""

    __slots__ = ()

    if TYPE_CHECKING:
        _definition: Definition
        _chain: Chain

        @property
        def joint_names(self) -> tuple[str, ...]: ...
        @property
        def joint_types(self) -> tuple[str, ...]: ...
        @property
        def lower(self) -> FloatArray: ...
        @property
        def upper(self) -> FloatArray: ...
        @property
        def home(self) -> FloatArray: ...
        @property
        def velocity_limits(self) -> FloatArray: ...

    def to_dict(self) -> dict[str, Any]:
        """Return the tables of the robot's file, as `Robot.save` writes them; m and rad.

        Examples
        --------
        >>> tables = ik.Robot.load("ur5e").to_dict()
        >>> tables["name"], tables["joint"][1]["name"]
        ('ur5e', 'shoulder_pan_joint')
        """
        from ._saving import tables

        return tables(self._definition, self._chain)

    def _columns(self) -> dict[str, Any]:
        kinds = list(self.joint_types)
        return {
            "joint": list(self.joint_names),
            "type": kinds,
            "lower": self.lower,
            "upper": self.upper,
            "home": self.home,
            "velocity": self.velocity_limits,
            "unit": ["m" if kind == "prismatic" else "rad" for kind in kinds],
        }
