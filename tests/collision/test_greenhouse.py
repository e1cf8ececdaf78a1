"""The made-up greenhouse is the specification's, bit for bit; the parts of crops."""

import numpy as np
import pytest

import spec_scenes
from agrik_fast.collision import (
    Scene,
    from_document,
    fruit,
    greenhouse,
    greenhouse_document,
    leaf,
    pipe,
    row,
    stalk,
    stem,
    wire,
)
from agrik_fast.errors import ArgumentError

GREENHOUSES = {
    "greenhouse1": {"seed": 1, "plants": 4, "leaves": 8, "clear_band": (0.65, 1.3)},
    "greenhouse2": {"seed": 2, "plants": 5, "leaves": 12},
}


@pytest.mark.parametrize("name", GREENHOUSES)
def test_the_reference_scenes_come_out_bit_for_bit(name: str) -> None:
    expected = spec_scenes.read("scenes_cucumber")[name]
    document = greenhouse_document(**GREENHOUSES[name])
    assert document["objects"] == expected["objects"]
    points = {where: target["point"] for where, target in document["targets"].items()}
    assert points == expected["targets"]


@pytest.mark.parametrize("name", GREENHOUSES)
def test_the_scene_is_that_of_the_document(name: str) -> None:
    scene = greenhouse(**GREENHOUSES[name])
    expected = spec_scenes.scenes("cucumber")[name]
    assert scene.names == expected.names
    for one, other in zip(scene.objects, expected.objects, strict=True):
        for rows in ("spheres", "capsules", "boxes", "halfspaces"):
            np.testing.assert_array_equal(getattr(one, rows), getattr(other, rows))
        assert (one.kind, one.removable) == (other.kind, other.removable)
    assert scene.targets["F1_0"].objects == ("F1_0", "stalk_F1_0")


def test_the_panda_s_greenhouse_is_one_of_these_moved() -> None:
    """Its file holds six decimals, in metres, without ground, pipes and machine."""
    pose = np.eye(4)
    pose[:3, 3] = -0.2, 0.0, -0.6
    scene = greenhouse(5, 3, 10, y0=-0.6, y1=0.6, machine=False).moved(pose)
    expected = spec_scenes.scenes("panda")["greenhouse5"]
    for one in expected.objects:
        ours = scene[one.name]
        np.testing.assert_allclose(ours.spheres, one.spheres, atol=6e-7)
        np.testing.assert_allclose(ours.capsules, one.capsules, atol=6e-7)


def test_seeds_and_sizes_matter() -> None:
    assert len(greenhouse(3, 2, 0, fruits=2)) == 4 + 2 * (2 + 4) + 2
    leaves = [greenhouse(seed, 2, 1)["leaf0_0"].spheres for seed in (3, 4)]
    assert (leaves[0] != leaves[1])[:, :3].all()
    assert len(greenhouse(0, 1, 1, points=40)["leaf0_0"].spheres) == 40
    low, high = 0.65, 1.3
    stripped = greenhouse(9, 3, 30, clear_band=(low, high))
    middles = [one.spheres[:, 2].mean() for one in stripped.objects if one.kind == "leaf"]
    # The points lie round the middle of a leaf, which is what the band is about.
    assert not any(low + 0.02 < middle < high - 0.02 for middle in middles)


@pytest.mark.parametrize(
    ("arguments", "place"),
    [
        ({"seed": -1}, "seed"),
        ({"plants": 1.5}, "plants"),
        ({"plants": 100_000, "leaves": 1000, "points": 10}, "points"),
        ({"points": 0}, "points"),
        ({"radius": -0.1}, "radius"),
        ({"y0": float("nan")}, "y0"),
        ({"clear_band": 3}, "clear_band"),
        ({"clear_band": (0.4, 1.9)}, "clear_band"),
        ({"machine": "no"}, "machine"),
    ],
)
def test_wrong_numbers_are_named(arguments: dict[str, object], place: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        greenhouse(**arguments)
    assert caught.value.argument == place


def test_parts_of_a_crop() -> None:
    plant = [
        stem("stem", [0.7, 0, 0.1], [0.7, 0, 1.9]),
        wire("string", [0.7, 0, 1.9], [0.7, 0, 2.4]),
        fruit("fruit", [0.65, 0.05, 1.2], 0.28),
        stalk("stalk", [0.65, 0.05, 1.2], [0.7, 0, 1.28]),
        leaf("leaf", [0.6, 0.1, 1.5], 0.1, azimuth=1.0, tilt=0.3, points=20),
    ]
    scene = Scene([*row(plant, 3, [0, 0.4, 0]), pipe("pipe", [0.8, -1, 0.06], [0.8, 1, 0.06])])
    assert len(scene) == 16
    assert {one.kind for one in scene.objects} == {
        "stem", "wire", "fruit", "stalk", "leaf", "pipe",
    }  # fmt: skip
    hanging = scene["fruit_2"].capsules[0]
    np.testing.assert_allclose(hanging, [0.65, 0.85, 1.175, 0.65, 0.85, 0.945, 0.025])
    blade = scene["leaf_0"]
    assert blade.removable and len(blade.spheres) == 20
    away = np.linalg.norm(blade.spheres[:, :3] - [0.6, 0.1, 1.5], axis=1)
    assert away.max() < 0.1 and np.allclose(away**2 * 20 / 0.01, np.arange(20) + 0.5)
    # All in one plane, which hangs down along its azimuth.
    normal = np.cross([np.cos(1) * np.cos(0.3), np.sin(1) * np.cos(0.3), -np.sin(0.3)],
                      [-np.sin(1), np.cos(1), 0])  # fmt: skip
    assert np.abs((blade.spheres[:, :3] - [0.6, 0.1, 1.5]) @ normal).max() < 1e-15
    with pytest.raises(ArgumentError, match="length"):
        fruit("fruit", [0, 0, 1], 0.04)
    with pytest.raises(ArgumentError, match="plant"):
        row(["leaf"], 2, [0, 1, 0])  # type: ignore[list-item]


def test_the_cucumber_s_own_file_is_the_reference_scene() -> None:
    scene = from_document(spec_scenes.cucumber_document())
    expected = spec_scenes.scenes("cucumber")["scene"]
    assert scene.names == expected.names
    for one, other in zip(scene.objects, expected.objects, strict=True):
        np.testing.assert_array_equal(one.spheres, other.spheres)
        np.testing.assert_array_equal(one.boxes, other.boxes)
    assert sum(len(one.spheres) for one in scene.objects) == 671
    assert scene.targets["C2"].objects == ("C2", "stalk_C2")
    assert ("base", "vehicle") in scene.exemptions
