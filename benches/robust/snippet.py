"""A failing row as a short program."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .chain import Arm, Array

if TYPE_CHECKING:
    from .requests import Request

BRANCHES = "ik_all"


def snippet(arm: Arm, request: Request | None = None, row: int = 0) -> str:
    """Return Python that asks for one row as the case did, alone.

    Differences between a batch and its rows, and hangs, need the whole case: `--case`.
    """
    lines = ["import numpy as np", "import agrik_fast as ik", "nan, inf = np.nan, np.inf"]
    lines += arm.code.rstrip().splitlines()
    if request is None:
        return "\n".join(lines)
    given = request.piece(row, row + 1)()
    lines.append(f"target = np.array({_numbers(given.pop('targets')[0])})")
    if row < len(request.reachable) and request.reachable[row]:
        lines.append(f"made_from = {_numbers(request.made_from[row])}")
    q0 = given.pop("q0")
    if q0 is not None:
        lines.append(f"q0 = {_numbers(q0[0] if q0.ndim == 2 else q0)}")
        given["q0"] = _Name("q0")
    given.pop("threads", None)
    named = {key: _written(value) for key, value in given.items()}
    arguments = ", ".join(["target", *(f"{key}={value}" for key, value in named.items())])
    lines.append(f"r = arm.{BRANCHES if request.solver_name == BRANCHES else 'ik'}({arguments})")
    if request.solver_name == BRANCHES:
        lines.append("print(ik.Status(r.status).name, r.valid, r.q)")
    else:
        lines.append(
            "print(ik.Status(r.status).name, r.q.tolist(), r.position_error, r.orientation_error)"
        )
    return "\n".join(lines)


class _Name(str):
    """Something that is written as it is."""


def _written(value: Any) -> str:
    if isinstance(value, _Name):
        return str(value)
    if hasattr(value, "tolist"):
        return _numbers(value)
    if value is None or isinstance(value, str | int | float | tuple):
        return repr(value)
    return f"ik.{type(value).__module__.split('.')[1]}.{value!r}"


def _numbers(array: Array) -> str:
    return repr(array.tolist())
