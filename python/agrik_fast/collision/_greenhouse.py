"""A made-up greenhouse, the same from the same seed: plants on strings, fruits, leaves, pipes.

The numbers come from SplitMix64 in a fixed order and are worked out in millimetres, so that
the same scenes can be made elsewhere, bit for bit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from .._checks import real_number, truth_value, whole_number
from ..errors import ArgumentError
from ._crop import spiral
from ._scene import Scene, from_document

_MASK = 2**64 - 1
_GAMMA = 0x9E3779B97F4A7C15
# Redraws of a leaf's height; a band that leaves no room would take for ever.
_REDRAWS = 10_000

# The machine of the cucumber paper's arm: the rail below its carriage, and its vehicle, mm.
_MACHINE = (
    ("slide", [0, 0, 560], [120, 760, 38]),
    ("vehicle", [0, 0, 360], [330, 900, 150]),
)


class _Stream:
    """SplitMix64 (Steele, Lea and Flood 2014), one number after the other."""

    def __init__(self, seed: int) -> None:
        self._state = seed

    def uniform(self, low: float, high: float) -> float:
        """Return the next number in [low, high), with 53 random bits."""
        self._state = (self._state + _GAMMA) & _MASK
        z = self._state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & _MASK
        return low + (high - low) * (((z ^ (z >> 31)) >> 11) * 2.0**-53)


def greenhouse(
    seed: int = 0,
    plants: int = 4,
    leaves: int = 8,
    *,
    points: int = 15,
    radius: float = 0.025,
    y0: float = -0.6,
    y1: float = 0.7,
    stem_x: float = 0.735,
    fruits: int = 1,
    clear_band: Sequence[float] | None = None,
    machine: bool = True,
) -> Scene:
    """Make a row of cucumber plants, by chance.

    World frame: x to the crop, y along the row, z up. Fruits, pipes, wires, stems and stalks
    are capsules, leaves are points. Targets are 60 mm below the top of each fruit, named as
    the fruit, which may be touched there, as its stalk may.

    Parameters
    ----------
    seed : int, default 0
        0 to 2**64 - 1.
    plants : int, default 4
        Plants in the row.
    leaves : int, default 8
        Leaves of a plant.
    points : int, default 15
        Points of a leaf.
    radius : float, default 0.025, m
        Radius of a leaf's points.
    y0, y1 : float, default -0.6 and 0.7, m
        Where the row begins and ends.
    stem_x : float, default 0.735, m
        Distance of the row.
    fruits : int, default 1
        Fruits of a plant.
    clear_band : (float, float), optional, m
        Heights between which leaves have been taken off.
    machine : bool, default True
        With the rail and the vehicle of the cucumber arm, "slide" and "vehicle".

    Returns
    -------
    Scene

    Raises
    ------
    ArgumentError
        A number out of its range.

    Examples
    --------
    >>> from agrik_fast.collision import greenhouse
    >>> scene = greenhouse(seed=1, plants=4, leaves=8, clear_band=(0.65, 1.3))
    >>> len(scene), list(scene.targets)
    (54, ['F0_0', 'F1_0', 'F2_0', 'F3_0'])
    """
    document = greenhouse_document(
        seed,
        plants,
        leaves,
        points=points,
        radius=radius,
        y0=y0,
        y1=y1,
        stem_x=stem_x,
        fruits=fruits,
        clear_band=clear_band,
        machine=machine,
    )
    return from_document(document, name="greenhouse")


def greenhouse_document(
    seed: int = 0,
    plants: int = 4,
    leaves: int = 8,
    *,
    points: int = 15,
    radius: float = 0.025,
    y0: float = -0.6,
    y1: float = 0.7,
    stem_x: float = 0.735,
    fruits: int = 1,
    clear_band: Sequence[float] | None = None,
    machine: bool = True,
) -> dict[str, Any]:
    """Make the same as `greenhouse`, as the content of a scene file in mm.

    Parameters
    ----------
    seed, plants, leaves, points, radius, y0, y1, stem_x, fruits, clear_band, machine
        As for `greenhouse`, lengths in m.

    Returns
    -------
    dict
        Its lengths are in mm, as they were worked out.

    Raises
    ------
    ArgumentError
        A number out of its range.

    Examples
    --------
    >>> ik.collision.greenhouse_document(seed=1, plants=2)["unit"]
    'mm'
    """
    stream = _Stream(whole_number("seed", seed, 0, _MASK))
    plants = whole_number("plants", plants, 0, 100_000)
    leaves = whole_number("leaves", leaves, 0, 100_000)
    points = whole_number("points", points, 1, 1_000_000)
    fruits = whole_number("fruits", fruits, 0, 1_000)
    if plants * leaves * points > 10**7:
        received = f"{plants} plants of {leaves} leaves of {points} points"
        raise ArgumentError("points", received, "at most 10^7 points in all")
    truth_value("machine", machine)
    first, last, x = _mm("y0", y0), _mm("y1", y1), _mm("stem_x", stem_x)
    ball, band = _mm("radius", radius, 0.0), _band(clear_band)
    objects: list[dict[str, Any]] = [
        {"name": "ground", "kind": "ground", "halfspaces": [[0, 0, 1, 0.0]]}
    ]
    for k, height in enumerate((60.0, 150.0)):
        ends = [x + 60.0, first, height, x + 60.0, last, height]
        objects.append({"name": f"pipe{k}", "kind": "pipe", "capsules": [[*ends, 25.5]]})
    ends = [x, first, 2400.0, x, last, 2400.0]
    objects.append({"name": "wire", "kind": "wire", "capsules": [[*ends, 2.0]]})
    targets: dict[str, Any] = {}
    pitch = (last - first) / max(1, plants)
    for plant in range(plants):
        y_stem = first + pitch * (plant + 0.5) + stream.uniform(-40, 40)
        x_stem = x + stream.uniform(-25, 25)
        objects += _stem(stream, plant, x_stem, y_stem)
        for number in range(fruits):
            objects += _fruit(stream, f"F{plant}_{number}", x_stem, y_stem, targets)
        for number in range(leaves):
            rows = _leaf(stream, x_stem, y_stem, points, ball, band)
            name = f"leaf{plant}_{number}"
            objects.append({"name": name, "kind": "leaf", "removable": True, "spheres": rows})
    if machine:
        objects += [
            {"name": name, "kind": "machine", "boxes": [{"centre": centre, "half": half}]}
            for name, centre, half in _MACHINE
        ]
    about = f"greenhouse(seed={seed}, plants={plants}, leaves={leaves})"
    return {"unit": "mm", "about": about, "targets": targets, "objects": objects}


def _mm(name: str, metres: float, low: float = -1e6) -> float:
    # What is meant is the decimal number, 735 and not 735.0000000000001.
    return round(real_number(name, metres, low, 1e6, unit="m") * 1000.0, 9)


def _band(clear_band: Sequence[float] | None) -> tuple[float, float] | None:
    if clear_band is None:
        return None
    try:
        low, high = clear_band
    except (TypeError, ValueError):
        raise ArgumentError("clear_band", repr(clear_band), "two heights, m") from None
    band = _mm("clear_band", low), _mm("clear_band", high)
    if band[0] <= 500.0 and band[1] >= 1800.0:
        raise ArgumentError("clear_band", repr(clear_band), "room for leaves in 0.5 to 1.8 m")
    return band


def _stem(stream: _Stream, plant: int, x: float, y: float) -> list[dict[str, Any]]:
    top = [x + stream.uniform(-15, 15), y + stream.uniform(-15, 15), 1900.0]
    string = [x, y, 1900.0, x, y, 2400.0, 1.5]
    return [
        {"name": f"stem{plant}", "kind": "stem", "capsules": [[x, y, 100.0, *top, 9.0]]},
        {"name": f"string{plant}", "kind": "wire", "capsules": [string]},
    ]


def _fruit(
    stream: _Stream, name: str, x_stem: float, y_stem: float, targets: dict[str, Any]
) -> list[dict[str, Any]]:
    x, y = x_stem - stream.uniform(40, 110), y_stem + stream.uniform(-90, 90)
    z, length = stream.uniform(820, 1250), stream.uniform(240, 320)
    body = [x, y, z - 25.0, x, y, z - length + 25.0, 25.0]
    holder = [x, y, z, x_stem, y_stem, z + 80.0, 4.0]
    targets[name] = {"point": [x, y, z - 60.0], "objects": [name, f"stalk_{name}"]}
    return [
        {"name": name, "kind": "fruit", "capsules": [body]},
        {"name": f"stalk_{name}", "kind": "stalk", "capsules": [holder]},
    ]


def _leaf(
    stream: _Stream,
    x: float,
    y: float,
    points: int,
    ball: float,
    band: tuple[float, float] | None,
) -> list[list[float]]:
    height = stream.uniform(500, 1800)
    for _ in range(_REDRAWS):
        if band is None or not band[0] < height < band[1]:
            break
        height = stream.uniform(500, 1800)
    azimuth, reach = stream.uniform(-math.pi, math.pi), stream.uniform(60, 200)
    disc, tilt = stream.uniform(80, 130), stream.uniform(-0.6, 0.9)
    centre = (x + reach * math.cos(azimuth), y + reach * math.sin(azimuth), height)
    return [[*place, ball] for place in spiral(centre, disc, azimuth, tilt, points)]
