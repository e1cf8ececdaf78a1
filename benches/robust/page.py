"""The page of measurements, as Markdown."""

from __future__ import annotations

import math
import os
import platform
import time
from collections.abc import Callable, Iterable, Sequence
from itertools import groupby

import agrik_fast as ik

from .measure import Measured

GOAL = 0.9999
"""Share of structured poses and positions that `lm` and `auto` have to solve."""


def write(measured: dict[str, list[Measured]], command: str, seconds: float) -> str:
    """Return the page.

    Parameters
    ----------
    measured : dict of list of Measured
        Measurements by section.
    command : str
        The command line that made them.
    seconds : float
        How long it took.
    """
    everything = [each for part in measured.values() for each in part]
    lines = [
        "# Robustness",
        "",
        "What share of targets is solved, and how often an answer claims what is not so: on arms "
        "as people have them, in postures as people set them. Every answer is judged by forward "
        "kinematics in plain NumPy that shares nothing with the library, by the limits of the "
        "robot's own file, and by the documented meaning of each status.",
        "",
        f"Made by `{command}` on {time.strftime('%Y-%m-%d')}, in {seconds / 60:.1f} minutes: "
        f"agrik_fast {ik.__version__}, {_cores()} cores, `simd_level()` {ik.simd_level()}, "
        f"Python {platform.python_version()}; every call with one thread, default tolerances "
        "(1e-6 m, 1e-6 rad), no start values.",
        "",
        *_summary(everything),
        "",
        *_words(),
    ]
    for title, text, make in SECTIONS:
        if measured.get(title):
            lines += ["", f"## {title}", "", text, "", *make(measured[title])]
    lines += ["", *_examples(everything)]
    return "\n".join(lines).rstrip() + "\n"


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _summary(everything: Sequence[Measured]) -> list[str]:
    rows = sum(each.rows for each in everything)
    lines = [
        f"**{rows:,} targets in all: {sum(e.false_successes for e in everything):,} false "
        f"successes, {sum(e.false_proofs for e in everything):,} false proofs, "
        f"{sum(e.others for e in everything):,} other broken promises.**"
    ]
    structured = [e for e in everything if e.kind == "structured"]
    if structured:
        short = [e for e in structured if e.share < GOAL]
        lines.append("")
        lines.append(
            f"Structured postures, at least {percent(GOAL)} solved by `lm` and `auto` each: "
            f"{len(structured) - len(short)} of {len(structured)} measurements reach it"
            + (
                "; short are " + ", ".join(f"{e.arm} ({e.task}, `{e.solver}`)" for e in short)
                if short
                else ""
            )
            + "."
        )
    return lines


def _words() -> list[str]:
    return [
        "| word | meaning |",
        "|---|---|",
        "| random | every joint evenly within its limits |",
        "| structured | every joint at 0, +-pi/2, pi/4, a limit, the middle, or random |",
        "| at limits | two joints of five at the lower, two at the upper limit |",
        "| next to limits | within 1e-15 to 1e-3 of the range from a limit |",
        "| straight | all or most joints at 0, or the wrist straight |",
        "| false success | `CONVERGED`, though errors exceed the tolerances, a limit is left, or a "
        "value is no number |",
        "| false proof | `OUT_OF_REACH` for a target that forward kinematics made from a posture "
        "within the limits |",
        "| other | a solution not claimed, an error told wrong, a joint a whole turn further from "
        "the middle of its limits than need be |",
        "| us | microseconds a target, with one thread: the median of the calls that a measurement "
        "is cut into |",
    ]


def percent(share: float) -> str:
    """Share in percent, rounded down: only all of the targets are 100 %."""
    return f"{math.floor(share * 1e6 + 1e-6) / 1e4:.4f}".rstrip("0").rstrip(".") + " %"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    rule = ["---", *("---:" for _ in head[1:])]
    return ["| " + " | ".join(cells) + " |" for cells in (head, rule, *rows)]


def _claims(each: Sequence[Measured]) -> list[str]:
    return [
        f"{sum(e.false_successes for e in each):,}",
        f"{sum(e.false_proofs for e in each):,}",
        f"{sum(e.others for e in each):,}",
    ]


CLAIMS = ["false successes", "false proofs", "other"]


def _by_arm(measured: Sequence[Measured]) -> list[str]:
    """One line an arm."""
    return _compact(measured, ("arm",), {"": _solved, "us": _time})


def _by_kind(measured: Sequence[Measured]) -> list[str]:
    """One line an arm and kind."""
    return _compact(measured, ("arm", "kind"), {"": _solved, "us": _time})


def _with_steps(measured: Sequence[Measured]) -> list[str]:
    return _compact(measured, ("arm", "kind"), {"": _solved, "steps": _steps})


def _beyond(measured: Sequence[Measured]) -> list[str]:
    return _compact(measured, ("arm",), {"": _proven, "us": _time})


def _compact(
    measured: Sequence[Measured],
    keys: Sequence[str],
    cells: dict[str, Callable[[Measured], str]],
) -> list[str]:
    """One line for all tasks and solvers of what `keys` tell apart, `cells` for each of them."""
    columns = list(dict.fromkeys((e.task, e.solver) for e in measured))
    head = [*keys, "targets each"]
    for task, solver in columns:
        head += [word or f"{task} `{solver}`" for word in cells]
    rows = []
    for key, group in groupby(measured, key=lambda e: [getattr(e, name) for name in keys]):
        each = list(group)
        line = [*key, f"{each[0].rows:,}"]
        by_column = {(e.task, e.solver): e for e in each}
        for column in columns:
            line += [make(by_column[column]) for make in cells.values()]
        rows.append([*line, *_claims(each)])
    return _table([*head, *CLAIMS], rows)


def _solved(each: Measured) -> str:
    return percent(each.share)


def _proven(each: Measured) -> str:
    return percent(each.out_of_reach / each.rows)


def _steps(each: Measured) -> str:
    return _number(each.iterations)


def _time(each: Measured) -> str:
    return _number(each.median_us)


def _number(value: float) -> str:
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def _examples(everything: Sequence[Measured]) -> list[str]:
    """One example of each broken promise, if there are any."""
    lines = []
    for kind in sorted({kind for each in everything for kind in each.faults}):
        first = next(each for each in everything if kind in each.faults)
        count = sum(each.faults[kind] for each in everything)
        place = f"{first.arm}, {first.kind}, {first.task}, `{first.solver}`"
        lines.append(f"* {kind} ({count:,}): {place}: {first.example[kind]}")
    return ["## Broken promises, one of each kind", "", *lines] if lines else []


Maker = Callable[[Sequence[Measured]], list[str]]

SECTIONS: list[tuple[str, str, Maker]] = [
    (
        "Structured postures",
        "The bundled arms, then arms out of the packages `example-robot-data` and `rtb-data` as "
        "their authors wrote them.",
        _by_arm,
    ),
    ("Other postures", "The bundled arms.", _by_kind),
    (
        "Scale, tools and rails",
        "Random postures of bundled arms: all lengths and the position tolerance multiplied by a "
        "factor, a rod on the tool, or the arm on a rail that is part of it. Steps are those of a "
        "target on average, over all its attempts.",
        _with_steps,
    ),
    (
        "Gantries",
        "Three crossed slides of one travel, from 1 mm to 10 km, with as many turning joints as "
        "named. All of the targets have to be solved.",
        _with_steps,
    ),
    (
        "No limits",
        "Joints that turn freely (continuous), or whose file writes large numbers for that; a "
        "cart's slides with limits of +-999999 m. Targets are within three metres.",
        _with_steps,
    ),
    (
        "Out of reach",
        "Points beyond all lengths and slides added up, on up to three times the distance: the "
        "share that is told `OUT_OF_REACH`.",
        _beyond,
    ),
]
"""Title, text and table of each part, in the order of the page."""
