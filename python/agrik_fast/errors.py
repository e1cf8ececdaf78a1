"""Exceptions of agrik_fast.

Every exception the library raises on purpose derives from `AgrikError`; those
about an argument's value are also a `ValueError`. The compiled module raises
the same classes. An unreachable target is never an exception: it is a
`agrik_fast.Status` in the result.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

__all__ = [
    "AgrikError",
    "ArgumentError",
    "ConcurrentUseError",
    "Fault",
    "GainFileError",
    "InternalError",
    "MissingExtraError",
    "RobotFileError",
    "RobotWarning",
    "SceneFileError",
    "SettingsWarning",
    "UnknownNameError",
    "UrdfError",
]


class AgrikError(Exception):
    """Base class of all exceptions of this library.

    Examples
    --------
    >>> try:
    ...     ik.Robot.load("no_such_arm")
    ... except ik.AgrikError as error:
    ...     print(type(error).__name__)
    UnknownNameError
    """


class ArgumentError(AgrikError, ValueError):
    """An argument has the wrong shape, type or value.

    Parameters
    ----------
    argument : str
        Name of the argument, as the caller wrote it (``"targets"``,
        ``"LevenbergMarquardt.max_restarts"``).
    received : str
        What came: the value or the shape, in words.
    expected : str
        What would have been accepted, in words.

    Attributes
    ----------
    argument, received, expected
        The parameters.

    Examples
    --------
    >>> try:
    ...     ik.Robot.load("ur5").fk([0.0, 0.0])
    ... except ik.ArgumentError as error:
    ...     print(error.argument)
    q
    """

    argument: str
    received: str
    expected: str

    def __init__(self, argument: str, received: str, expected: str) -> None:
        self.argument = argument
        self.received = received
        self.expected = expected
        super().__init__(f"`{argument}`: expected {expected}, got {received}")

    def __reduce__(self) -> tuple[Any, ...]:
        # The default rebuilds from `args`, which holds the message only; worker
        # processes could then not hand the exception back.
        return type(self), (self.argument, self.received, self.expected)


class ConcurrentUseError(AgrikError, RuntimeError):
    """An object that serves one caller at a time was called while it was at work.

    By another thread, by a signal handler, or by an argument whose conversion to an array
    calls back.

    Parameters
    ----------
    object : str
        What was called.
    instead : str
        What to do instead, in words.

    Attributes
    ----------
    object, instead
        The parameters.
    """

    object: str
    instead: str

    def __init__(self, object: str, instead: str) -> None:
        self.object = object
        self.instead = instead
        super().__init__(f"{object} is at work for another caller; {instead}")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.object, self.instead)


class InternalError(AgrikError):
    """A fault of the library itself, in its compiled part; please report it.

    What is raised is also a `RuntimeError`.
    """

    def __str__(self) -> str:
        return (
            f"internal fault of agrik_fast ({super().__str__()}); this is a bug, please report "
            "it with the call that led here"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return InternalError, self.args


class MissingExtraError(AgrikError, ImportError):
    """Something needs a library that the base installation does not bring.

    Parameters
    ----------
    what : str
        What needs it, in words.
    extra : str
        Name of the extra that brings it.

    Attributes
    ----------
    what, extra
        The parameters.
    """

    what: str
    extra: str

    def __init__(self, what: str, extra: str) -> None:
        self.what = what
        self.extra = extra
        super().__init__(f"{what}: needs an extra, pip install 'agrik_fast[{extra}]'")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.what, self.extra)


class RobotWarning(UserWarning):
    """Something about a robot that is allowed and seldom meant."""


class TargetWarning(UserWarning):
    """Something about targets or start values that is allowed and seldom meant."""


class SettingsWarning(UserWarning):
    """Something changes the settings of a solver from their usual values."""


class GainFileError(AgrikError, ValueError):
    """A gain file, or a tuner's checkpoint, cannot be used.

    Parameters
    ----------
    file : str
        Name of the file.
    reason : str
        What is wrong, and where in the file.

    Attributes
    ----------
    file, reason
        The parameters.
    """

    file: str
    reason: str

    def __init__(self, file: str, reason: str) -> None:
        self.file = file
        self.reason = reason
        super().__init__(f"{file}: {reason}")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.file, self.reason)


class UnknownNameError(ArgumentError):
    """A name (robot, solver, task, frame, link) is not known.

    Parameters
    ----------
    kind : str
        What the name should be the name of: ``"robot"``, ``"solver"``, ...
    name : str
        The name that came.
    known : iterable of str
        The names that would have been accepted.

    Attributes
    ----------
    kind, name : str
        The parameters.
    known : tuple of str
        All accepted names.
    nearest : tuple of str
        Up to three accepted names that look like `name`, best first.

    Examples
    --------
    >>> try:
    ...     ik.Robot.load("pumma560")
    ... except ik.UnknownNameError as error:
    ...     print(error.nearest)
    ('puma560',)
    """

    kind: str
    name: str
    known: tuple[str, ...]
    nearest: tuple[str, ...]

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        self.kind = kind
        self.name = name
        self.known = tuple(known)
        self.nearest = nearest_names(name, self.known)
        listing = ", ".join(self.known)
        super().__init__(kind, repr(name), f"one of {listing}")
        hint = ""
        if self.nearest:
            hint = "; did you mean " + " or ".join(repr(n) for n in self.nearest) + "?"
        self.args = (f"unknown {kind} {name!r}{hint or '.'} Known: {listing}",)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.kind, self.name, self.known)


# Faults that a message names.
_TOLD = 100
_LETTERS = 400
"""Of each of them."""


class Fault(NamedTuple):
    """One fault of a robot file or a scene file.

    Attributes
    ----------
    place : str
        Table, row (counted from 1) and key, for example ``[[dh]] row 3, a_mm``.
    message : str
        What is wrong there.

    Examples
    --------
    >>> fault = ik.errors.Fault(place="joint[2].a_m", message="is not a number")
    >>> fault.place
    'joint[2].a_m'
    """

    place: str
    message: str

    def __str__(self) -> str:
        return f"{self.place}: {self.message}" if self.place else self.message


def _short(text: str) -> str:
    return text if len(text) <= _LETTERS else f"{text[: _LETTERS - 3]}..."


class _FaultyFileError(AgrikError, ValueError):
    """A file cannot be used; carries every fault found in it."""

    file: str
    faults: tuple[Fault, ...]

    def __init__(self, file: str, faults: Iterable[tuple[str, str]]) -> None:
        self.file = file
        self.faults = tuple(Fault(place, message) for place, message in faults)
        count = len(self.faults)
        head = f"{file}: {count} fault{'' if count == 1 else 's'}"
        more = [f"  and {count - _TOLD} more"] if count > _TOLD else []
        told = [f"  {_short(str(fault))}" for fault in self.faults[:_TOLD]]
        super().__init__("\n".join([head, *told, *more]))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.file, self.faults)


class RobotFileError(_FaultyFileError):
    """A robot file cannot be used; carries every fault found in it.

    Parameters
    ----------
    file : str
        Name of the file.
    faults : iterable of (place, message)
        The faults, in the order of the file.

    Attributes
    ----------
    file : str
        Name of the file.
    faults : tuple of Fault
        The faults.

    Examples
    --------
    >>> import pathlib
    >>> _ = pathlib.Path("broken.toml").write_text('format = 1')
    >>> try:
    ...     ik.Robot.load("broken.toml")
    ... except ik.RobotFileError as error:
    ...     print(len(error.faults) >= 1)
    True
    """


class SceneFileError(_FaultyFileError):
    """A scene file or a cloud of points cannot be used; carries every fault found in it.

    Parameters
    ----------
    file : str
        Name of the file.
    faults : iterable of (place, message)
        The faults, in the order of the file.

    Attributes
    ----------
    file : str
        Name of the file.
    faults : tuple of Fault
        The faults.

    Examples
    --------
    >>> import pathlib
    >>> _ = pathlib.Path("broken_scene.toml").write_text('unit = "inch"')
    >>> try:
    ...     ik.Scene.load("broken_scene.toml")
    ... except ik.SceneFileError as error:
    ...     print(error.faults[0].place)
    unit
    """


class UrdfError(AgrikError, ValueError):
    """A URDF cannot be read, or does not describe one serial chain.

    Examples
    --------
    >>> try:
    ...     ik.Robot.from_urdf('<robot name="r"><link name="alone"/></robot>')
    ... except ik.UrdfError:
    ...     print("no joint moves")
    no joint moves
    """


def nearest_names(name: str, known: Iterable[str]) -> tuple[str, ...]:
    """Return up to three names of `known` that look like `name`, best first.

    Parameters
    ----------
    name : str
        What was typed.
    known : iterable of str
        Candidates.

    Returns
    -------
    tuple of str
        The nearest candidates, ignoring case; empty if none is near.
    """
    import difflib

    by_lower = {candidate.lower(): candidate for candidate in known}
    matches = difflib.get_close_matches(name.lower(), list(by_lower), n=3, cutoff=0.6)
    return tuple(by_lower[match] for match in matches)
