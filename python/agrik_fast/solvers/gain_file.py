"""Gain files: tuned gains with everything that is needed to use them rightly.

A TOML or JSON file says for which robot and start the gains are, in which units and along
which axes they are written, on what they were trained and how they did on goals kept
apart. Unknown keys, wrong types and matrices that do not fit are refused.
"""

from __future__ import annotations

import dataclasses
import json
import math
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeVar, cast

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    FiniteFloat,
    ValidationError,
    model_validator,
)

from .._atomic import write_bytes
from .._checks import shown, truth_value
from .._files import decode, listing, parse_json, parse_toml, read_bytes
from .._warnings import warn
from ..errors import ArgumentError, GainFileError, SettingsWarning, UnknownNameError
from ._feedback import IDENTITY, IkPid, StateSpace, StaticGain

__all__ = ["GainFile", "bundled", "load", "read", "text", "write"]

_FOLDER = Path(__file__).parent / "bundled"
_LENGTHS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001}
_ANGLES = {"rad": 1.0, "deg": math.pi / 180}
# How many faults a message names.
_FAULTS = 20
_Row = list[FiniteFloat]
_Rows = Annotated[list[_Row], Field(min_length=1)]
_Count = Annotated[int, Field(ge=0)]
_Number = Annotated[int, Field(ge=1)]
_SolverT = TypeVar("_SolverT")


class _Table(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class UnitsTable(_Table):
    """Units that the gains are written in."""

    length: Literal["m", "dm", "cm", "mm"]
    """Of the position error."""
    angle: Literal["rad", "deg"]
    """Of what revolute joints are moved by."""
    rotation_length_m: FiniteFloat | None = None
    """Length that one radian of orientation error counts as, m."""


class FrameTable(_Table):
    """Axes of the error."""

    name: str = "base"
    """Name of the frame, as in the robot's file."""
    rotation: Annotated[list[_Row], Field(min_length=3, max_length=3)] = [
        list(row) for row in IDENTITY
    ]
    """Leads directions of the robot's first link to these axes."""


class GainsTable(_Table):
    """The numbers: A, B and C, or K, or kp, ki and kd."""

    A: _Rows | None = None
    """States by states."""
    B: _Rows | None = None
    """States by rows of the error."""
    C: _Rows | None = None
    """Joint values by states."""
    K: _Rows | None = None
    """Joint values by rows of the error."""
    kp: FiniteFloat | None = None
    """Proportional gain."""
    ki: FiniteFloat | None = None
    """Integral gain."""
    kd: FiniteFloat | None = None
    """Derivative gain."""


class TrainingTable(_Table):
    """What the gains were tuned on."""

    origin: str
    """Where they are from, in words."""
    law: str | None = None
    """How the training goals were drawn."""
    seed: _Count | None = None
    """Seed of the training goals."""
    goals: _Number | None = None
    """Number of training goals."""
    evaluations: _Count | None = None
    """Gain sets that the search judged."""
    cost: FiniteFloat | None = None
    """Mean cost on the training goals."""
    solved: _Count | None = None
    """Training goals reached."""
    validation_seed: _Count | None = None
    """Seed of the goals that the choice between gain sets was made on."""
    validation_goals: _Number | None = None
    """Number of these."""
    validation_solved: _Count | None = None
    """How many of these the chosen set reaches."""

    @model_validator(mode="after")
    def _no_more_than_there_are(self) -> Self:
        _check_share("solved", self.solved, self.goals)
        _check_share("validation_solved", self.validation_solved, self.validation_goals)
        return self


class SuccessTable(_Table):
    """How the gains do on goals kept apart from the training."""

    law: str
    """How the goals were drawn."""
    seed: _Count
    """Seed of the goals."""
    goals: _Number
    """Number of goals."""
    solved: _Count
    """Goals reached."""
    tolerance_m: Annotated[FiniteFloat, Field(gt=0)]
    """Distance that counts as reached, m."""
    tolerance_rad: Annotated[FiniteFloat, Field(gt=0)] | None = None
    """Angle that counts as reached, rad, where the goals are poses."""
    max_iterations: _Number
    """Steps allowed."""
    mean_iterations: Annotated[FiniteFloat, Field(ge=0)] | None = None
    """Mean steps over the goals reached."""

    @model_validator(mode="after")
    def _no_more_than_there_are(self) -> Self:
        _check_share("solved", self.solved, self.goals)
        return self


def _check_share(name: str, solved: int | None, goals: int | None) -> None:
    if solved is not None and goals is not None and solved > goals:
        raise ValueError(f"{name}: {solved} of {goals} goals")


class GainFile(_Table):
    """A gain file's content.

    Examples
    --------
    >>> from agrik_fast.solvers import gain_file
    >>> content = gain_file.read("ur5_static_cma")
    >>> content.solver, content.robot
    ('static-gain', 'ur5')
    """

    format: Literal[1] = 1
    """Version of this form: 1."""
    solver: Literal["state-space", "static-gain", "ik-pid"]
    """Whose gains these are."""
    robot: str | None = None
    """Name of the robot they were tuned for."""
    start: Literal["sampled", "zero", "middle"]
    """Start they were tuned for."""
    description: str = ""
    """One line."""
    units: UnitsTable
    """Units of the numbers."""
    frame: FrameTable = FrameTable()
    """Axes of the error."""
    gains: GainsTable
    """The numbers."""
    training: TrainingTable
    """What they were tuned on."""
    success: SuccessTable | None = None
    """How they do on other goals."""

    def make(self) -> StateSpace | StaticGain | IkPid:
        """Return the solver: one attempt from the start that the gains were tuned for.

        Raises
        ------
        ArgumentError
            Gains are missing or do not fit together.

        Examples
        --------
        >>> from agrik_fast.solvers import gain_file
        >>> type(gain_file.read("ur5_static_cma").make()).__name__
        'StaticGain'
        """
        given = self.gains.model_dump(exclude_none=True)
        wanted = {"state-space": "ABC", "static-gain": "K", "ik-pid": ("kp", "ki", "kd")}
        names = tuple(wanted[self.solver])
        if set(given) != set(names):
            raise ArgumentError("gains", ", ".join(given) or "nothing", ", ".join(names))
        common: dict[str, Any] = {
            "length_unit_m": _LENGTHS[self.units.length],
            "angle_unit_rad": _ANGLES[self.units.angle],
            "start": self.start,
            "max_iterations": 1000,
            "max_restarts": 0,
            "robot": self.robot,
        }
        if self.solver == "ik-pid":
            return IkPid(**given, **common)
        common["frame"] = self.frame.rotation
        common["rotation_length_m"] = self.units.rotation_length_m
        if self.solver == "static-gain":
            return StaticGain(**given, **common)
        return StateSpace(**given, **common)


def bundled() -> tuple[str, ...]:
    """Return the names of the bundled gain sets, sorted.

    Examples
    --------
    >>> from agrik_fast.solvers import gain_file
    >>> "hydrolek_k15_cma" in gain_file.bundled()
    True
    """
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


def read(source: str | PathLike[str]) -> GainFile:
    """Read and check a gain file.

    Parameters
    ----------
    source : str or path
        Path of a .toml or .json file, or the name of a bundled set.

    Returns
    -------
    GainFile
        The content.

    Raises
    ------
    UnknownNameError
        Neither a file nor a bundled set.
    GainFileError
        The file holds no valid gains; says what is wrong and where.

    Examples
    --------
    >>> from agrik_fast.solvers import gain_file
    >>> gain_file.read("hydrolek_k15_cma").robot
    'hydrolek'
    """
    return _read(source)[0]


def _read(source: str | PathLike[str]) -> tuple[GainFile, StateSpace | StaticGain | IkPid]:
    """Return the content of a gain file and its solver, made once: it may warn."""
    path = Path(source)
    if path.suffix not in (".toml", ".json"):
        name = str(source)
        if name not in bundled():
            raise UnknownNameError("gain set", name, bundled())
        path = _FOLDER / f"{name}.toml"
    refuse = partial(GainFileError, path.name)
    parse = parse_json if path.suffix == ".json" else parse_toml
    raw = parse(decode(read_bytes(path, refuse), refuse), refuse)
    try:
        content = GainFile.model_validate(raw)
        solver = content.make()
    except ValidationError as error:
        found = error.errors(include_url=False, include_input=False, include_context=False)
        faults = [
            f"{listing(['.'.join(map(str, item['loc']))]) or 'the whole'}: {item['msg'].lower()}"
            for item in found[:_FAULTS]
        ]
        if len(found) > _FAULTS:
            faults.append(f"and {len(found) - _FAULTS} more")
        head = f"{len(found)} faults\n  " if len(found) > 1 else ""
        raise GainFileError(path.name, head + "\n  ".join(faults)) from None
    except ArgumentError as error:
        raise GainFileError(path.name, str(error)) from None
    return content, solver


def load(
    source: str | PathLike[str], kind: type[_SolverT] | None, as_tuned: bool | None = None
) -> _SolverT:
    """Return the solver of a gain file; see `agrik_fast.solvers.load_gains`.

    Examples
    --------
    >>> from agrik_fast.solvers import StateSpace, gain_file
    >>> gain_file.load("hydrolek_k15_cma", StateSpace, as_tuned=True).start
    'zero'
    """
    names: dict[object, str] = {known: known.name for known in (StateSpace, StaticGain, IkPid)}
    if kind is not None and kind not in names:
        raise ArgumentError("kind", repr(kind), "StateSpace, StaticGain or IkPid")
    _, read = _read(source)
    if kind is not None and not isinstance(read, kind):
        message = f"holds gains for {read.name!r}, not for {names[kind]!r}"
        raise GainFileError(str(source), message)
    solver = cast(_SolverT, read)
    if as_tuned is None:
        _say_what_changed(source, solver)
    elif not truth_value("as_tuned", as_tuned):
        usual: Any = {name: field.default for name, field in _loop(solver).items()}
        return cast(_SolverT, dataclasses.replace(cast(Any, solver), **usual))
    return solver


_LOOP = ("max_iterations", "max_restarts", "start")


def _loop(solver: object) -> dict[str, dataclasses.Field[Any]]:
    """Return the fields of the loop that a gain file sets."""
    return {each.name: each for each in dataclasses.fields(cast(Any, solver)) if each.name in _LOOP}


def _say_what_changed(source: str | PathLike[str], solver: object) -> None:
    changed = [
        f"{name} {getattr(solver, name)!r} (usually {field.default!r})"
        for name, field in _loop(solver).items()
        if getattr(solver, name) != field.default
    ]
    if changed:
        warn(
            f"{source}: as the gains were tuned, {', '.join(changed)}; as_tuned=False takes the "
            "usual settings, as_tuned=True these without a word",
            SettingsWarning,
        )


def text(path: Path, content: GainFile) -> str:
    """Return what a gain file holds, TOML or JSON by its suffix.

    Raises
    ------
    ArgumentError
        Another suffix.
    """
    given: object = content
    if not isinstance(given, GainFile):
        raise ArgumentError("content", shown(given), "a GainFile")
    tables = content.model_dump(exclude_none=True)
    if path.suffix == ".json":
        return json.dumps(tables, indent=2) + "\n"
    if path.suffix == ".toml":
        import tomli_w

        return tomli_w.dumps(tables)
    raise ArgumentError("output", str(path), "a name that ends in .toml or .json")


def write(path: Path, content: GainFile, *, force: bool = True) -> None:
    """Write a gain file, TOML or JSON by its suffix.

    The file appears under its name only when it is complete and on the disk.

    Parameters
    ----------
    path : path
        Its name; a symbolic link is followed.
    content : GainFile
        What it holds.
    force : bool
        Replace an existing file.

    Raises
    ------
    ArgumentError
        Another suffix.
    GainFileError
        The file cannot be written, or exists and `force` is False.

    Examples
    --------
    >>> import pathlib
    >>> from agrik_fast.solvers import gain_file
    >>> content = gain_file.read("ur5_static_cma")
    >>> gain_file.write(pathlib.Path("gains.toml"), content)
    >>> gain_file.read("gains.toml") == content
    True
    """
    force = truth_value("force", force)
    refuse = partial(GainFileError, str(path))
    write_bytes(path, text(path, content).encode(), refuse, force=force)
