"""Every public callable, found by a walk: bad input raises documented exceptions and nothing else.

What is public is discovered, so that what comes later is walked too: it needs an example for each
new class and each new name of a required argument in the tables below, and the walk says so.
"""

import dataclasses
import functools
import importlib
import inspect
import pkgutil
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pydantic
import pytest

import agrik_fast as ik
from agrik_fast import _native
from agrik_fast.closed_form import StrawberryArm, TomatoArm
from agrik_fast.errors import AgrikError
from agrik_fast.tune import Tuning

# Files have tests of their own, which damage them; papers are scripts that write files.
ELSEWHERE = ("agrik_fast.cli", "agrik_fast.io", "agrik_fast.papers")
# Reading or writing the file that is named, whose absence is an OSError's business.
FILES = {"path", "source", "name_or_path", "checkpoint"}
# Exceptions and codes hold what they are given; tables of files are checked by their readers,
# which turn the model's error into one of ours.
RECORDS = (BaseException, tuple, int, pydantic.BaseModel)

ARM = ik.Robot.load("redundant7")
SOLVER = ARM.solver()
STRAWBERRY = StrawberryArm()
TOMATO = TomatoArm()


@functools.cache
def receivers() -> dict[type, Any]:
    """An object of each class whose methods are walked."""
    return {
        ik.Robot: ARM,
        _native.TargetSolver: SOLVER,
        StrawberryArm: STRAWBERRY,
        TomatoArm: TOMATO,
    }


# Records that the library makes and nobody else.
ANSWERS = {
    "Branches", "Command", "IkResult", "PacedResult", "Path", "Report", "StrawberryResult",
    "TomatoBranches", "TomatoResult", "Torques",
}  # fmt: skip
# Words and objects of one type: of these the walk gives words that nobody knows. What is no word
# at all is the type checker's business.
WORDS = {
    "axes", "base_link", "case", "choose", "convention", "current", "frame", "joint_names",
    "joint_types", "kind", "label", "mark", "method", "name", "order", "path_or_text", "robot",
    "shape", "start", "source", "name_or_path", "theta_rule", "tip_link", "tuning", "path", "gain",
    "content", "chunks", "checkpoint", "resume", "report",
}  # fmt: skip
# How many: huge numbers ask for more memory than there is.
COUNTS = {"count", "n", "draws", "goals", "samples"}

POSES = ARM.fk(ARM.random_q(2, seed=1))
# An argument of each name that is in order.
ARGUMENTS: dict[str, Any] = {
    "angles": np.zeros(3),
    "argument": "a",
    "a": np.zeros(3),
    "b": np.zeros(3),
    "beta": 1.0,
    "case": "fixed",
    "center": np.zeros(3),
    "chunks": [POSES],
    "count": 3,
    "current": np.zeros(3),
    "frame": "base",
    "max_joint_step": 0.1,
    "method": "transpose",
    "name_or_path": "ur5",
    "pose": POSES[0],
    "position": np.zeros(3),
    "position_m": np.array([0.1, 0.0, 0.3]),
    "q": np.zeros(7),
    "q_rad": np.zeros(3),
    "radius": 1.0,
    "robot": ARM,
    "rows": np.ones((3, 4)),
    "seed": 1,
    "solver": ik.solvers.DifferentialEvolution(generations=1, max_restarts=0),
    "source": '<robot name="r"/>',
    "target": POSES[0],
    "targets": POSES,
    "theta": 0.1,
    "tool": np.eye(4),
    "base": np.eye(4),
    "tuning": Tuning(goals=10, evaluations=4, runs=1, refinement=0),
}
# Arguments that differ from what others of their name are.
EXACTLY: dict[str, Any] = {}


class Unprintable:
    def __repr__(self) -> str:
        raise ValueError("no words")


def bad_values() -> list[Any]:
    shapes = [(0,), (3,), (7,), (2, 3), (2, 7), (4, 4), (2, 4, 4), (0, 3), (0, 4, 4)]
    numbers = [np.nan, np.inf, -1.0, 1e300]
    return [
        None, True, -1, 0, 2**70, 10**400, 0.5, np.nan, -np.inf, 1e300, 5e-324, 1j, "", "x", "\0",
        "\ud800", b"x", [], [[1, 2], [3]], {}, {1}, object(), Unprintable(), ik.Robot, lambda: 0,
        range(3), np.array(None), np.array(["a"]), np.zeros(3, dtype="M8[s]"), np.zeros(3, bool),
        np.zeros(3, complex), np.zeros((1,) * 40 + (3,)), [10**400] * 3,
        *(np.full(shape, x) for shape in shapes for x in numbers),
    ]  # fmt: skip


def values_for(argument: str) -> list[Any]:
    values = bad_values()
    if argument in WORDS:
        return [value for value in values if isinstance(value, str) and value != "\ud800"]
    if argument in COUNTS:
        return [value for value in values if not (isinstance(value, int) and value > 10**6)]
    return values


def public_modules() -> Iterator[Any]:
    yield ik
    for found in pkgutil.walk_packages(ik.__path__, "agrik_fast."):
        private = any(part.startswith("_") for part in found.name.split("."))
        if not private and not found.name.startswith(ELSEWHERE):
            yield importlib.import_module(found.name)


def public_objects() -> list[tuple[str, Any]]:
    found = {}
    for module in public_modules():
        for name in module.__all__:
            thing = getattr(module, name)
            if callable(thing):
                found[id(thing)] = (f"{thing.__module__}.{thing.__qualname__}", thing)
    return sorted(found.values(), key=lambda pair: pair[0])


def methods(kind: type) -> Iterator[tuple[str, Callable[..., Any]]]:
    """The public methods of a class, bound."""
    for name in dir(kind):
        raw = inspect.getattr_static(kind, name)
        if name.startswith("_") or isinstance(raw, (property, type)) or not callable(
            getattr(kind, name)
        ):
            continue
        if isinstance(raw, (classmethod, staticmethod)):
            yield f"{kind.__qualname__}.{name}", getattr(kind, name)
        elif kind in receivers():
            yield f"{kind.__qualname__}.{name}", getattr(receivers()[kind], name)


def callables() -> dict[str, Callable[..., Any]]:
    found: dict[str, Callable[..., Any]] = {}
    for name, thing in [*public_objects(), ("TargetSolver", _native.TargetSolver)]:
        if not isinstance(thing, type):
            found[name] = thing
            continue
        if issubclass(thing, RECORDS) or thing.__name__ in ANSWERS:
            continue
        if thing.__module__ != "agrik_fast._native":
            found[name] = thing
        found |= dict(methods(thing))
    return found


CALLABLES = callables()


def test_the_walk_finds_what_there_is():
    names = " ".join(CALLABLES)
    for one in ("Robot.ik", "Robot.from_dh", "TargetSolver.solve", "tasks.Masked", "euler.",
                "StrawberryArm.solve", "TomatoArm.iterate", "set_num_threads", "tune.tune"):  # fmt: skip
        assert one in names, one


def test_the_walk_knows_an_object_of_every_class_with_methods():
    for name, thing in public_objects():
        if isinstance(thing, type) and not issubclass(thing, RECORDS):
            known = thing in receivers() or thing.__name__ in ANSWERS
            # All there is to settings is how they are made.
            assert known or dataclasses.is_dataclass(thing), f"{name}: say in `receivers` how to make one"


def taken(name: str, call: Callable[..., Any]) -> dict[str, inspect.Parameter]:
    try:
        signature = inspect.signature(call)
    except ValueError:
        pytest.fail(f"{name} does not tell its arguments")
    variable = (inspect.Parameter.VAR_KEYWORD, inspect.Parameter.VAR_POSITIONAL)
    return {k: p for k, p in signature.parameters.items() if p.kind not in variable}


def example(name: str, argument: str) -> Any:
    key = f"{name.rpartition('.')[2]}.{argument}"
    if key in EXACTLY:
        return EXACTLY[key]
    assert argument in ARGUMENTS, f"{name}({argument}=...): give an example in `ARGUMENTS`"
    return ARGUMENTS[argument]


def consumed(answer: Any) -> None:
    """Takes what a generator gives."""
    if inspect.isgenerator(answer):
        for _ in answer:
            pass


@pytest.mark.parametrize("name", CALLABLES)
def test_bad_arguments_raise_what_is_documented(name):
    call = CALLABLES[name]
    parameters = taken(name, call)
    required = {
        k: example(name, k) for k, p in parameters.items() if p.default is inspect.Parameter.empty
    }
    faults = []
    for argument in parameters:
        for bad in values_for(argument):
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    consumed(call(**{**required, argument: bad}))
            except AgrikError as error:
                assert str(error), name
            except OSError:
                assert argument in FILES, name
            except Exception as error:
                kind = type(bad).__name__ + (str(bad.shape) if hasattr(bad, "shape") else "")
                faults.append(f"{argument}={kind}: {type(error).__name__}: {str(error)[:90]}")
    assert not faults, "\n".join([name, *faults])


@pytest.mark.parametrize("name", CALLABLES)
def test_an_unknown_argument_is_a_type_error(name):
    call = CALLABLES[name]
    if any(p.kind is p.VAR_KEYWORD for p in inspect.signature(call).parameters.values()):
        return
    with pytest.raises((TypeError, AgrikError)):
        call(no_such_argument=1)
