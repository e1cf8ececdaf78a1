"""Files of labelled points, as cameras and scanners write them: PLY, PCD, NPZ, CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray, float_array, real_number, text, truth_value, word
from .._checks import path as checked_path
from .._checks import shown as shown_value
from .._files import Refusal, decode, listing, read_bytes, reading, shown
from .._npy import Archive
from ..errors import ArgumentError, SceneFileError
from ._objects import SceneObject
from ._pcd import read_pcd
from ._ply import read_ply
from ._rows import POINT, faulty
from ._solids_in_tables import numbers_in
from ._tables import UNITS

CLOUD_SUFFIXES = (".ply", ".pcd", ".npz", ".csv")
# Twenty million points of a camera with colours.
CLOUD_BYTES = 1 << 30
_RADIUS = ("radius", "radii", "r")
_LABEL = ("label", "labels")

Columns = dict[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class Cloud:
    """Points with radii and labels.

    Parameters
    ----------
    points : array_like, shape (n, 3), m
    radii : float or array_like, shape (n,), m
        0 or more.
    labels : array_like, shape (n,), optional
        Which object each point belongs to: whole numbers or text. Without them all points
        are one object.

    Raises
    ------
    ArgumentError
        A wrong shape, NaN or infinity, a negative radius.

    Examples
    --------
    >>> cloud = ik.collision.Cloud([[0.6, 0.0, 0.9], [0.6, 0.5, 0.9]], 0.02, labels=[1, 2])
    >>> [one.name for one in ik.collision.objects_of(cloud)]
    ['cloud_1', 'cloud_2']
    """

    points: FloatArray
    radii: FloatArray
    labels: NDArray[Any] | None = None

    def __post_init__(self) -> None:
        points = float_array("points", self.points)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ArgumentError("points", f"shape {points.shape}", "shape (n, 3)")
        bad = faulty(POINT, points)
        if len(bad):
            received = f"{points[bad[0]].tolist()} in row {bad[0] + 1}"
            raise ArgumentError("points", received, "finite numbers")
        radii = float_array("radii", self.radii)
        if radii.shape not in ((), (len(points),)):
            raise ArgumentError("radii", f"shape {radii.shape}", f"shape ({len(points)},)")
        radii = np.broadcast_to(radii, len(points)).copy()
        wrong = np.flatnonzero(~((radii >= 0.0) & np.isfinite(radii)))
        if len(wrong):
            received = f"{radii[wrong[0]]:g} in row {wrong[0] + 1}"
            raise ArgumentError("radii", received, "numbers >= 0")
        object.__setattr__(self, "points", points.copy())
        object.__setattr__(self, "radii", radii)
        if self.labels is not None:
            try:
                labels = np.asarray(self.labels)
            except ValueError:
                labels = np.zeros(0)
            if labels.shape != (len(points),) or labels.dtype.kind not in "iuU":
                received = f"shape {labels.shape} of {labels.dtype}"
                expected = f"shape ({len(points)},) of whole numbers or text"
                raise ArgumentError("labels", received, expected)
            object.__setattr__(self, "labels", labels)

    def __len__(self) -> int:
        return len(self.points)


def read_cloud(
    path: str | PathLike[str],
    *,
    unit: str,
    radius: float | None = None,
    drop_nan: bool = False,
) -> Cloud:
    """Read a file of points.

    Parameters
    ----------
    path : str or path
        ``.ply`` or ``.pcd`` (text or binary; PCD compressed as well), ``.npz`` (``points``,
        shape (n, 3), ``radius``, ``labels``) or ``.csv`` (a line of names, then numbers). The
        columns are x, y, z and, where there are any, ``radius`` and ``label``; others are
        passed over.
    unit : {"m", "mm"}
        Unit of the points and radii, which none of these files says.
    radius : float, m, optional
        Radius of the points where the file has none.
    drop_nan : bool, default False
        Leave out points with NaN, which depth cameras write where they saw nothing, instead
        of refusing the file.

    Returns
    -------
    Cloud
        In metres.

    Raises
    ------
    SceneFileError
        The file is damaged, ends early, claims more than it holds, has no radius and none is
        given, holds NaN or a negative radius; says in which row.
    ArgumentError
        The path leads to no file of a known kind.

    Examples
    --------
    >>> import pathlib
    >>> rows = "x,y,z,radius", "0.6,0,0.9,0.02", "0.6,0.02,0.9,0.02"
    >>> _ = pathlib.Path("leaf.csv").write_text(chr(10).join(rows))
    >>> len(ik.collision.read_cloud("leaf.csv", unit="m").points)
    2
    """
    file = checked_path("path", path)
    if file.suffix not in CLOUD_SUFFIXES:
        raise ArgumentError("path", repr(str(file)), f"a {', '.join(CLOUD_SUFFIXES)} file")
    if not file.is_file():
        raise ArgumentError("path", f"{str(file)!r}, which is no file", "an existing file")
    word("unit", unit, UNITS)
    if radius is not None:
        radius = real_number("radius", radius, 0.0, unit="m")
    truth_value("drop_nan", drop_nan)

    def refuse(reason: str) -> SceneFileError:
        return SceneFileError(file.name, [("", reason)])

    columns = _npz(file, refuse) if file.suffix == ".npz" else _parsed(file, refuse)
    points, radii, labels = _chosen(columns, refuse)
    if drop_nan:
        kept = ~np.isnan(points).any(axis=1)
        points = points[kept]
        radii = radii if radii is None else radii[kept]
        labels = labels if labels is None else labels[kept]
    return _in_metres(points, radii, labels, UNITS[unit], radius, refuse)


def _in_metres(
    points: FloatArray,
    radii: FloatArray | None,
    labels: NDArray[Any] | None,
    scale: float,
    radius: float | None,
    refuse: Refusal,
) -> Cloud:
    points = numbers_in(points, scale)
    bad = faulty(POINT, points)
    if len(bad):
        row = bad[0]
        raise refuse(
            f"point {row + 1}: expected finite numbers x, y, z, got {points[row].tolist()}"
            f"{f', and {len(bad) - 1} more such points' if len(bad) > 1 else ''}"
        )
    if radii is None and radius is None:
        raise refuse("has no column 'radius', and no radius was given")
    each = numbers_in(radii, scale) if radii is not None else np.full(len(points), radius)
    wrong = np.flatnonzero(~((each >= 0.0) & np.isfinite(each)))
    if len(wrong):
        raise refuse(f"point {wrong[0] + 1}: expected a radius >= 0, got {each[wrong[0]]:g}")
    return Cloud(points, each, labels)


def objects_of(
    cloud: Cloud,
    *,
    names: Mapping[Any, str] | None = None,
    name: str = "cloud",
    kind: str = "",
    removable: bool = False,
) -> list[SceneObject]:
    """Make one object of each label of a cloud.

    Parameters
    ----------
    cloud : Cloud
        Points with labels.
    names : mapping, optional
        Name of an object by its label, or by the label as text. Those without are called by
        their label, after `name` and an underscore if it is a number.
    name : str, default "cloud"
        Name of the only object of a cloud without labels.
    kind, removable : optional
        What the objects are, as for `SceneObject`.

    Returns
    -------
    list of SceneObject
        In the order in which the labels come first; the points in their own order.

    Raises
    ------
    ArgumentError
        A name that is not text.

    Examples
    --------
    >>> from agrik_fast.collision import Cloud, objects_of
    >>> cloud = Cloud([[0, 0, 1], [0, 0, 2], [1, 0, 1]], 0.02, [7, 7, 3])
    >>> [(one.name, len(one)) for one in objects_of(cloud, names={7: "leaf"})]
    [('leaf', 2), ('cloud_3', 1)]
    """
    text("name", name)
    if not isinstance(cloud, Cloud):
        raise ArgumentError("cloud", shown_value(cloud), "a Cloud")
    rows = np.column_stack([cloud.points, cloud.radii])
    if cloud.labels is None:
        _known_names(names)
        return [SceneObject(name, kind, removable, spheres=rows)]
    known = _known_names(names)
    labels, first, which = np.unique(cloud.labels, return_index=True, return_inverse=True)
    order = np.argsort(which, kind="stable")
    ends = np.searchsorted(which[order], np.arange(len(labels) + 1))
    objects = []
    for k in np.argsort(first).tolist():
        label = labels[k].item()
        own = label if isinstance(label, str) else f"{name}_{label}"
        mine = rows[order[ends[k] : ends[k + 1]]]
        objects.append(SceneObject(known.get(str(label), own), kind, removable, spheres=mine))
    return objects


def _known_names(names: object) -> dict[str, str]:
    if names is None:
        return {}
    if not isinstance(names, Mapping):
        raise ArgumentError("names", shown_value(names), "a mapping of labels to names")
    return {str(label): text("names", one) for label, one in names.items()}


# ---- columns of each kind of file ----------------------------------------------------------


def _parsed(file: Path, refuse: Refusal) -> Columns:
    read: Callable[[bytes, Refusal], Columns]
    read = {".ply": read_ply, ".pcd": read_pcd, ".csv": _csv}[file.suffix]
    return read(read_bytes(file, refuse, CLOUD_BYTES), refuse)


def _chosen(
    columns: Columns, refuse: Refusal
) -> tuple[FloatArray, FloatArray | None, NDArray[Any] | None]:
    missing = [axis for axis in "xyz" if axis not in columns]
    if missing:
        found = listing(columns) or "nothing"
        raise refuse(f"has no column {', '.join(missing)}; found {found}")
    points = np.column_stack([_doubles(axis, columns[axis], refuse) for axis in "xyz"])
    radius = next((name for name in _RADIUS if name in columns), None)
    label = next((name for name in _LABEL if name in columns), None)
    radii = None if radius is None else _doubles(radius, columns[radius], refuse)
    return points, radii, None if label is None else _labels(columns[label], refuse)


def _doubles(name: str, values: NDArray[Any], refuse: Refusal) -> FloatArray:
    if values.dtype.kind not in "fiu":
        raise refuse(f"column {name}: expected numbers, got {values.dtype}")
    return values.astype(np.float64)


def _labels(values: NDArray[Any], refuse: Refusal) -> NDArray[Any]:
    if values.dtype.kind == "f":
        with np.errstate(invalid="ignore"):
            whole = values.astype(np.int64)
        odd = np.flatnonzero(whole != values)
        if len(odd):
            got = f"{values[odd[0]]:g}"
            raise refuse(f"point {odd[0] + 1}: expected a whole number as its label, got {got}")
        return whole
    if values.dtype.kind not in "iuU":
        raise refuse(f"labels are {values.dtype}, expected whole numbers or text")
    return values


def _npz(file: Path, refuse: Refusal) -> Columns:
    with Archive(file, refuse) as archive:
        if "points" not in archive.names:
            raise refuse(f"has no array 'points'; found {listing(archive.names) or 'nothing'}")
        points = archive.array("points")
        if points.ndim != 2 or points.shape[1] != 3:
            raise refuse(f"'points' of shape {points.shape}, expected (n, 3)")
        columns = {axis: points[:, k] for k, axis in enumerate("xyz")}
        for name in (*_RADIUS, *_LABEL):
            if name not in archive.names:
                continue
            values = archive.array(name)
            if values.shape == () and name in _RADIUS:
                values = np.broadcast_to(values, len(points))
            if values.shape != (len(points),):
                raise refuse(f"'{name}' of shape {values.shape}, expected ({len(points)},)")
            columns[name] = values
    return columns


def _csv(data: bytes, refuse: Refusal) -> Columns:
    content = decode(data.removeprefix(b"\xef\xbb\xbf"), refuse)
    with reading(refuse, "is not a CSV file"):
        rows = [
            (number, row)
            for number, row in enumerate(csv.reader(io.StringIO(content, newline="")), start=1)
            if any(field.strip() for field in row) and not row[0].lstrip().startswith("#")
        ]
    if not rows:
        raise refuse("is empty, expected a line of names")
    if len(rows) == 1:
        raise refuse("holds no points")
    names = [field.strip().lower() for field in rows[0][1]]
    twice = {name for name in names if name and names.count(name) > 1}
    if twice:
        raise refuse(f"line {rows[0][0]}: {listing(sorted(twice))} twice")
    for number, row in rows[1:]:
        if len(row) != len(names):
            last = ", and the file ends with it" if row is rows[-1][1] else ""
            raise refuse(f"line {number}: expected {len(names)} fields, got {len(row)}{last}")
    columns: Columns = {}
    for k, name in enumerate(names):
        if name not in ("x", "y", "z", *_RADIUS, *_LABEL):
            continue
        fields = [row[k].strip() for _, row in rows[1:]]
        columns[name] = _column(name, fields, [number for number, _ in rows[1:]], refuse)
    return columns


def _column(name: str, fields: list[str], lines: list[int], refuse: Refusal) -> NDArray[Any]:
    if name in _LABEL and not all(field.lstrip("-").isdigit() for field in fields):
        if "" in fields:
            raise refuse(f"line {lines[fields.index('')]}: expected a label, got nothing")
        return np.array(fields, dtype=str)
    try:
        return np.array(fields, dtype=str).astype(np.float64)
    except ValueError:
        for number, field in zip(lines, fields, strict=True):
            try:
                float(field)
            except ValueError:
                message = f"line {number}, {name}: expected a number, got {shown(field)}"
                raise refuse(message) from None
        raise refuse(f"column {name}: expected numbers") from None
