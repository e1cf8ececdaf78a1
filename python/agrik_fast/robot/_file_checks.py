"""Checks of a robot file that need more than one key, on its raw tables.

They skip whatever has the wrong type: `_file` reports that itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from .._files import listing, shown
from ..errors import Fault, nearest_names

_TO_SI = {"m": 1.0, "mm": 1e-3, "rad": 1.0, "deg": math.pi / 180.0}
_LENGTH, _ANGLE = ("m", "mm"), ("rad", "deg")

MOTION = {"velocity": "_s", "acceleration": "_s2", "jerk": "_s3"}
"""Limits of motion, and what their units have behind the unit of the joint's value."""

NAMED_FAULTS = 20
"""Faults that are told with the name that was perhaps meant."""

# How far a rotation matrix in a file may be from orthonormal: nine printed digits.
_ORTHONORMAL = 1e-8


def key_of(stem: str, unit: str) -> str:
    """Return the key under which a file has a number, its unit at the end."""
    return f"{stem}_{unit}{MOTION.get(stem, '')}"


def quantity(table: Mapping[str, Any], stem: str) -> Any:
    """Return the number, list or rows under `stem` and any unit, in m or rad; None if absent."""
    for unit, factor in _TO_SI.items():
        value = table.get(key_of(stem, unit))
        if isinstance(value, list):
            return [
                [_to_si(x, unit, factor) for x in v] if isinstance(v, list)
                else _to_si(v, unit, factor) for v in value
            ]  # fmt: skip
        if value is not None:
            return _to_si(value, unit, factor)
    return None


def _to_si(value: float, unit: str, factor: float) -> float:
    try:
        value = float(value)
    except OverflowError:
        return math.inf
    # math.radians and a division by 1000 round once; a factor would round twice.
    if unit == "deg":
        return math.radians(value)
    return value / 1000.0 if unit == "mm" else value * factor


def combined_faults(raw: Mapping[str, Any]) -> list[Fault]:
    """Return the faults of a file's tables that a check of single keys cannot see."""
    return list(_faults(raw))


def _faults(raw: Mapping[str, Any]) -> Iterator[Fault]:
    marks = raw.get("provenance")
    for place, table in _transforms(raw):
        yield from transform_faults(place, table)
        yield from mark_faults(place, table, marks)
    dh, joints = _tables(raw.get("dh")), _tables(raw.get("joint"))
    if bool(raw.get("dh")) == bool(raw.get("joint")):
        got = "both" if raw.get("dh") else "neither"
        yield Fault("", f"expected either [[dh]] or [[joint]] rows, got {got}")
    if raw.get("dh") and "convention" not in raw:
        yield Fault("convention", "missing: [[dh]] rows are 'standard' or 'modified'")
    if raw.get("joint") and "convention" in raw:
        yield Fault("convention", "only for [[dh]] rows, but the file has [[joint]] rows")
    for index, row in dh:
        place = f"[[dh]] row {index}"
        for stem, units in (("a", _LENGTH), ("alpha", _ANGLE), ("d", _LENGTH), ("theta", _ANGLE)):
            yield from one_unit(place, row, stem, units, required=True)
        yield from _limit_faults(place, row)
        yield from _motion_faults(place, row)
        yield from _home_faults(place, row)
        yield from mark_faults(place, row, marks)
    for index, row in joints:
        place = f"[[joint]] row {index}"
        yield from transform_faults(place, row)
        yield from _axis_faults(place, row)
        yield from _limit_faults(place, row)
        yield from _motion_faults(place, row)
        yield from _home_faults(place, row)
        yield from mark_faults(place, row, marks)
    for kind, rows in (("dh", dh), ("joint", joints)):
        yield from _name_faults(kind, rows)
    yield from _mimic_faults(joints)
    yield from _order_faults(raw.get("q_order"), dh or joints)


def _tables(value: Any) -> list[tuple[int, Mapping[str, Any]]]:
    if not isinstance(value, list):
        return []
    return [(i, row) for i, row in enumerate(value, start=1) if isinstance(row, dict)]


def _transforms(raw: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    for key in ("base", "tool"):
        if isinstance(raw.get(key), dict):
            yield f"[{key}]", raw[key]
    frames = raw.get("frames")
    for name, table in frames.items() if isinstance(frames, dict) else ():
        if isinstance(table, dict):
            yield f"[frames.{name}]", table


def one_unit(
    place: str, table: Mapping[str, Any], stem: str, units: Sequence[str], *, required: bool
) -> Iterator[Fault]:
    """Faults of a number that is given in two units, or in none."""
    keys = [key_of(stem, unit) for unit in units]
    given = [key for key in keys if key in table]
    if len(given) > 1:
        yield Fault(f"{place}, {stem}", f"given twice, as {' and '.join(given)}")
    if required and not given:
        yield Fault(f"{place}, {stem}", f"missing; expected {' or '.join(keys)}")


def _limit_faults(place: str, row: Mapping[str, Any]) -> Iterator[Fault]:
    kind = row.get("type")
    if kind not in ("revolute", "prismatic", "continuous", "fixed"):
        return
    bounded = kind in ("revolute", "prismatic")
    units = _LENGTH if kind == "prismatic" else _ANGLE
    for stem in ("lower", "upper"):
        allowed = units if bounded else ()
        for key in (f"{stem}_{unit}" for unit in _TO_SI if unit not in allowed):
            if key in row and bounded:
                want = " or ".join(f"{stem}_{unit}" for unit in units)
                yield Fault(f"{place}, {key}", f"wrong unit for a {kind} joint; expected {want}")
            elif key in row:
                yield Fault(f"{place}, {key}", f"a {kind} joint has no limits")
        yield from one_unit(place, row, stem, units, required=bounded)
    lower, upper = (_number(row, stem) for stem in ("lower", "upper"))
    if bounded and lower is not None and upper is not None and lower > upper:
        yield Fault(f"{place}, lower", f"expected lower <= upper, got {lower:g} > {upper:g}")


def _motion_faults(place: str, row: Mapping[str, Any]) -> Iterator[Fault]:
    kind = row.get("type")
    units = _LENGTH if kind == "prismatic" else _ANGLE
    for stem in MOTION:
        given = [unit for unit in _TO_SI if key_of(stem, unit) in row]
        for unit in given:
            key = f"{place}, {key_of(stem, unit)}"
            if kind == "fixed":
                yield Fault(key, "a fixed joint does not move")
            elif unit not in units:
                want = " or ".join(key_of(stem, unit) for unit in units)
                yield Fault(key, f"wrong unit for a {kind} joint; expected {want}")
        yield from one_unit(place, row, stem, units, required=False)
        value = _number(row, stem)
        if value is not None and not value > 0.0:
            yield Fault(f"{place}, {stem}", f"expected a number above 0, got {value:g}")


def _home_faults(place: str, row: Mapping[str, Any]) -> Iterator[Fault]:
    kind = row.get("type")
    keys = [f"home_{unit}" for unit in _TO_SI if f"home_{unit}" in row]
    if kind == "fixed" or "mimic" in row:
        why = "is fixed" if kind == "fixed" else "follows another"
        for key in keys:
            yield Fault(f"{place}, {key}", f"the joint {why} and has no value of its own")
        return
    units = _LENGTH if kind == "prismatic" else _ANGLE
    for key in keys:
        if key.removeprefix("home_") not in units:
            want = " or ".join(f"home_{unit}" for unit in units)
            yield Fault(f"{place}, {key}", f"wrong unit for a {kind} joint; expected {want}")
    yield from one_unit(place, row, "home", units, required=False)
    home, lower, upper = (_number(row, stem) for stem in ("home", "lower", "upper"))
    if home is not None and lower is not None and upper is not None and not lower <= home <= upper:
        yield Fault(f"{place}, home", f"expected a value within the limits {lower:g} and {upper:g}")


def _number(table: Mapping[str, Any], stem: str) -> float | None:
    for unit, factor in _TO_SI.items():
        value = table.get(key_of(stem, unit))
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return _to_si(value, unit, factor)
    return None


def _array(value: Any, shape: tuple[int, ...]) -> np.ndarray[Any, np.dtype[np.float64]] | None:
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        return None
    return array if array.shape == shape and np.isfinite(array).all() else None


def transform_faults(place: str, table: Mapping[str, Any]) -> Iterator[Fault]:
    """Faults of a place and a turn."""
    yield from one_unit(place, table, "xyz", _LENGTH, required=False)
    yield from one_unit(place, table, "rpy", _ANGLE, required=False)
    if "rotation" not in table:
        return
    if "rpy_rad" in table or "rpy_deg" in table:
        yield Fault(f"{place}, rotation", "given twice, as rotation and as rpy")
    rotation = _array(table["rotation"], (3, 3))
    if rotation is None:
        return
    with np.errstate(over="ignore", invalid="ignore"):
        off = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if not off <= _ORTHONORMAL:
        yield Fault(
            f"{place}, rotation",
            f"expected orthonormal rows (to {_ORTHONORMAL:g}), got rows off by {off:.3g}",
        )
    elif np.linalg.det(rotation) < 0:
        yield Fault(f"{place}, rotation", "expected a right-handed frame, got a mirrored one")


def _axis_faults(place: str, row: Mapping[str, Any]) -> Iterator[Fault]:
    if row.get("type") == "fixed":
        if "axis" in row:
            yield Fault(f"{place}, axis", "a fixed joint has no axis")
        if "mimic" in row:
            yield Fault(f"{place}, mimic", "a fixed joint follows no other")
    elif "axis" not in row:
        yield Fault(f"{place}, axis", "missing")
    else:
        axis = _array(row["axis"], (3,))
        if axis is not None and not axis.any():
            yield Fault(f"{place}, axis", "expected a direction of non-zero length, got zero")


def mark_faults(place: str, table: Mapping[str, Any], marks: Any) -> Iterator[Fault]:
    """Faults of the marks that say where the numbers of a table are from."""
    notes = table.get("provenance")
    for key, note in notes.items() if isinstance(notes, dict) else ():
        if key not in table and not any(key_of(key, unit) in table for unit in _TO_SI):
            yield Fault(f"{place}, provenance.{key}", "names no number of this table")
        mark = note.partition(":")[0] if isinstance(note, str) else None
        if mark is not None and not (isinstance(marks, dict) and mark in marks):
            yield Fault(
                f"{place}, provenance.{key}",
                f"mark {shown(mark)} is not explained in [provenance]",
            )


def _name_faults(kind: str, rows: Sequence[tuple[int, Mapping[str, Any]]]) -> Iterator[Fault]:
    first: dict[str, int] = {}
    for index, row in rows:
        name = row.get("name")
        if isinstance(name, str) and first.setdefault(name, index) != index:
            yield Fault(
                f"[[{kind}]] row {index}, name",
                f"{shown(name)} is the name of row {first[name]} too",
            )
    if rows and all(row.get("type") == "fixed" for _, row in rows):
        yield Fault(f"[[{kind}]]", "expected at least one joint that moves, got fixed joints only")


def _mimic_faults(rows: Sequence[tuple[int, Mapping[str, Any]]]) -> Iterator[Fault]:
    by_name = {row["name"]: row for _, row in rows if isinstance(row.get("name"), str)}
    unknown = 0
    for index, row in rows:
        mimic = row.get("mimic")
        if not isinstance(mimic, dict):
            continue
        place = f"[[joint]] row {index}, mimic"
        units = _LENGTH if row.get("type") == "prismatic" else _ANGLE
        for unit in _TO_SI:
            if f"offset_{unit}" in mimic and unit not in units:
                yield Fault(
                    f"{place}.offset_{unit}",
                    f"expected offset_{units[0]} or offset_{units[1]} on a {row.get('type')} joint",
                )
        yield from one_unit(place, mimic, "offset", units, required=False)
        source = mimic.get("joint")
        if not isinstance(source, str):
            continue
        if source not in by_name:
            unknown += 1
            near = nearest_names(source[:60], by_name) if unknown <= NAMED_FAULTS else ()
            hint = f"; did you mean {shown(near[0])}?" if near else ""
            yield Fault(f"{place}.joint", f"no joint is named {shown(source)}{hint}")
        elif "mimic" in by_name[source] or by_name[source].get("type") == "fixed":
            yield Fault(
                f"{place}.joint",
                f"expected a moving joint that follows no other, got {shown(source)}",
            )


def _order_faults(order: Any, rows: Sequence[tuple[int, Mapping[str, Any]]]) -> Iterator[Fault]:
    if not isinstance(order, list) or not rows:
        return
    names = [r.get("name") for _, r in rows if r.get("type") != "fixed" and "mimic" not in r]
    if not all(isinstance(name, str) for name in (*names, *order)):
        return
    if sorted(order) != sorted(str(name) for name in names):
        wanted = listing(str(name) for name in names)
        yield Fault("q_order", f"expected each of {wanted} once, got {listing(order)}")
