"""Scenes and their files: one format, all faults at once, the same bits back."""

from __future__ import annotations

import json
import pickle
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agrik_fast.collision import (
    Box,
    Capsule,
    Convex,
    HalfSpace,
    Scene,
    SceneObject,
    Sphere,
    Target,
    document_of,
    from_document,
    greenhouse,
)
from agrik_fast.errors import ArgumentError, SceneFileError, UnknownNameError

TURN = [[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]
EVERY_KIND: dict[str, Any] = {
    "format": 1,
    "unit": "mm",
    "about": "one of each",
    "touch_radius": 120,
    "exemptions": [["base", "floor"]],
    "targets": {"ball": [100, 0, 500], "post": {"point": [1, 2, 3], "objects": ["ball", "post"]}},
    "objects": [
        {"name": "ball", "kind": "fruit", "removable": True, "spheres": [[100, 0, 500, 40]]},
        {"name": "leaf", "points": [[0, 0, 100], [0, 0, 200]], "radius": 25, "note": "two points"},
        {"name": "each", "points": [[0, 0, 1], [0, 0, 2]], "radius": [3, 4]},
        {"name": "post", "capsules": [[[0, 0, 0], [0, 0, 900], 20], [0, 0, 0, 9, 9, 9, 1]]},
        {"name": "crate", "boxes": [{"centre": [1, 2, 3], "half": [4, 5, 6], "R": TURN},
                                    {"centre": [1, 2, 3], "half": [4, 5, 6], "radius": 7}]},
        {"name": "floor", "kind": "ground", "halfspaces": [[0, 0, 1, -20], [[0, 1, 0], -900]]},
        {"name": "wedge", "hulls": [{"vertices": [[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]],
                                     "radius": 1}]},
    ],
}  # fmt: skip


def write(folder: Path, name: str, text: str) -> Path:
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def assert_same(one: Scene, other: Scene) -> None:
    assert one.names == other.names
    assert dict(one.targets) == dict(other.targets)
    assert one.exemptions == other.exemptions
    assert one.touch_radius == other.touch_radius
    for a, b in zip(one.objects, other.objects, strict=True):
        assert (a.kind, a.removable) == (b.kind, b.removable)
        for rows in ("spheres", "capsules", "boxes", "halfspaces"):
            np.testing.assert_array_equal(getattr(a, rows), getattr(b, rows))
        assert len(a.hulls) == len(b.hulls)
        for (points, radius), (others, other_radius) in zip(a.hulls, b.hulls, strict=True):
            np.testing.assert_array_equal(points, others)
            assert radius == other_radius


def faults(document: Any) -> dict[str, str]:
    """Faults of a document as place: message; each place once."""
    with pytest.raises(SceneFileError) as caught:
        from_document(document, name="scene.json")
    found = caught.value.faults
    assert str(caught.value).startswith("scene.json: ")
    assert len({fault.place for fault in found}) == len(found), found
    return dict(found)


def test_every_kind_of_solid_is_read_in_metres() -> None:
    scene = from_document(EVERY_KIND)
    assert scene["ball"].spheres.tolist() == [[0.1, 0.0, 0.5, 0.04]]
    assert scene["ball"].removable and scene["ball"].kind == "fruit"
    assert scene["leaf"].spheres.tolist() == [[0, 0, 0.1, 0.025], [0, 0, 0.2, 0.025]]
    assert scene["each"].spheres[:, 3].tolist() == [0.003, 0.004]
    assert scene["post"].capsules[0].tolist() == [0, 0, 0, 0, 0, 0.9, 0.02]
    assert scene["crate"].boxes[0].tolist() == [
        0.001, 0.002, 0.003, 0.004, 0.005, 0.006, 0.6, -0.8, 0, 0.8, 0.6, 0, 0, 0, 1, 0,
    ]  # fmt: skip
    assert scene["crate"].boxes[1, 15] == 0.007
    assert scene["floor"].halfspaces.tolist() == [[0, 0, 1, -0.02], [0, 1, 0, -0.9]]
    points, radius = scene["wedge"].hulls[0]
    assert points.max() == 0.009 and radius == 0.001
    assert scene.touch_radius == 0.12
    # A target without a list may be touched where it names an object.
    assert scene.targets["ball"] == Target((0.1, 0.0, 0.5), ("ball",))
    assert scene.targets["post"].objects == ("ball", "post")
    in_metres = from_document({**EVERY_KIND, "unit": "m"})
    assert in_metres["ball"].spheres.tolist() == [[100, 0, 500, 40]]


@pytest.mark.parametrize("suffix", [".json", ".toml"])
def test_a_saved_scene_reads_back_to_the_same_bits(tmp_path: Path, suffix: str) -> None:
    for number, scene in enumerate(
        [from_document(EVERY_KIND), greenhouse(3, 2, 4), Scene(), Scene(touch_radius=0.2)]
    ):
        path = tmp_path / f"scene{number}{suffix}"
        scene.save(path, about="a \"test\" of \\ 'letters' and Umlauts: ä")
        assert_same(Scene.load(path), scene)
        assert_same(pickle.loads(pickle.dumps(scene)), scene)
    with pytest.raises(SceneFileError, match="exists already"):
        scene.save(path)
    scene.save(path, force=True)
    mm = tmp_path / f"mm{suffix}"
    from_document(EVERY_KIND).save(mm, unit="mm")
    again = Scene.load(mm)
    np.testing.assert_allclose(again["ball"].spheres, [[0.1, 0, 0.5, 0.04]], rtol=1e-15)
    assert document_of(again, unit="mm")["unit"] == "mm"


def test_paths_and_units_that_make_no_sense(tmp_path: Path) -> None:
    for call in (Scene().save, Scene.load):
        with pytest.raises(ArgumentError, match=r"expected a .json or .toml file"):
            call(tmp_path / "scene.yaml")
    with pytest.raises(ArgumentError, match="which is no file"):
        Scene.load(tmp_path / "absent.json")
    with pytest.raises(UnknownNameError, match="unit"):
        Scene().save(tmp_path / "scene.json", unit="cm")
    with pytest.raises(SceneFileError, match="cannot be written"):
        Scene().save(tmp_path / "nowhere" / "scene.json")


def test_all_faults_are_told_at_once_with_their_places() -> None:
    found = faults(
        {
            "unit": "cm",
            "objekts": [],
            "touch_radius": -1,
            "exemptions": [["hand", "nothing"], ["hand"]],
            "targets": {"A": {"point": [1, 2]}, "B": [1, 2, "x"],
                        "C": {"point": [1, 2, 3], "objects": ["lef"]}},
            "objects": [
                {"name": "leaf", "kynd": "x",
                 "spheres": [[0, 0, 0, -1], [0, float("nan"), 0, 1], [1, 2, 3], [0, 0, 0, 1]]},
                {"name": "leaf", "points": [[0, 0, 0]]},
                {"name": "q", "radius": 2},
                {"name": "each", "points": [[0, 0, 0]], "radius": [1, 2]},
                {"name": "neg", "points": [[0, 0, 0]], "radius": [-1]},
                {"name": "w", "capsules": [[0, 0, 0, 1, 1, 1, 0.1], [[0, 0, 0], [0, 0, 1], "x"]],
                 "halfspaces": [[0, 0, 0, 1]]},
                {"name": "b", "boxes": [{"centre": [0, 0, 0], "half": [1, 1, -1]},
                                        {"centre": [0, 0], "half": [1, 1, 1]},
                                        {"centre": [0, 0, 0], "half": [1, 1, 1],
                                         "R": [[1, 0, 0], [0, 2, 0], [0, 0, 1]]}]},
                {"hulls": [{"vertices": []}, {"vertices": [[0, 0, "a"]], "radius": -1}]},
            ],
        }
    )  # fmt: skip
    one, six, seven = "objects row 1 ('leaf')", "objects row 6 ('w')", "objects row 7 ('b')"
    expected = {
        "unit": "'m' or 'mm'",
        "objekts": "did you mean 'objects'?",
        "touch_radius": "greater than or equal to 0",
        "exemptions row 1": "no object is named 'nothing'",
        "exemptions row 2": "at least 2 items",
        "targets, A, point": "at least 3 items",
        "targets, B, point row 3": "valid number, got 'x'",
        "targets.C, objects": "no object is named 'lef'; did you mean 'leaf'?",
        f"{one}, kynd": "did you mean 'kind'?",
        f"{one}, spheres row 1": "expected a radius >= 0, got radius -1",
        f"{one}, spheres row 2": "expected finite numbers",
        f"{one}, spheres row 3": "expected 4 numbers: x, y, z, radius, got [1, 2, 3]",
        "objects row 2 ('leaf'), radius": "missing: points need one",
        "objects row 2 ('leaf'), name": "'leaf' is the name of row 1 too",
        "objects row 3 ('q'), radius": "belongs to points, of which there are none",
        "objects row 4 ('each'), radius": "expected 1 numbers, got 2",
        "objects row 5 ('neg'), radius row 1": "expected a number >= 0, got -1",
        f"{six}, capsules row 2": "expected 7 numbers",
        f"{six}, halfspaces row 1": "a normal of no length",
        f"{seven}, boxes row 1, half": "expected half lengths >= 0",
        f"{seven}, boxes row 2, centre": "at least 3 items",
        f"{seven}, boxes row 3, R": "expected orthonormal rows",
        "objects row 8, name": "missing",
        "objects row 8, hulls row 1, vertices": "expected at least one point",
        "objects row 8, hulls row 2, vertices row 1": "expected 3 numbers",
        "objects row 8, hulls row 2, radius": "greater than or equal to 0",
    }
    assert set(found) == set(expected)
    for place, words in expected.items():
        assert words in found[place], (place, found[place])


def test_no_unit_is_a_fault_that_says_what_is_missing() -> None:
    assert faults({"objects": []}) == {
        "unit": "missing: 'm' or 'mm', the unit of every length in the file"
    }


def test_what_is_no_table_is_refused() -> None:
    for wrong in ([], 3, "x", None):
        assert "expected a table of keys" in faults(wrong)[""]
    assert set(faults({"unit": "m", "objects": {}, "targets": [], "clouds": 1})) == {
        "objects", "targets", "clouds",
    }  # fmt: skip


def test_many_faulty_rows_are_counted() -> None:
    rows = [[0, 0, 0, -1]] * 50 + [[0, 0]] * 70
    with pytest.raises(SceneFileError, match="50 more such rows") as caught:
        from_document({"unit": "m", "objects": [{"name": "a", "spheres": rows}]})
    assert "30 more such rows" in str(caught.value)
    assert len(caught.value.faults) == 42


@pytest.mark.parametrize("suffix", [".json", ".toml"])
def test_files_cut_off_in_the_middle_are_refused(tmp_path: Path, suffix: str) -> None:
    whole = tmp_path / f"whole{suffix}"
    from_document(EVERY_KIND).save(whole)
    text = whole.read_text()
    refused = 0
    for length in range(0, len(text) - 1, 7):
        cut = write(tmp_path, f"cut{suffix}", text[:length])
        try:
            Scene.load(cut)
        except SceneFileError:
            refused += 1
        else:
            # A TOML text may end after any of its lines; what is in it is sound then.
            assert suffix == ".toml"
    assert refused > (0.99 if suffix == ".json" else 0.8) * len(range(0, len(text) - 1, 7))
    if suffix == ".json":
        with pytest.raises(SceneFileError, match=r"not a JSON file: .*line \d+ column \d+"):
            Scene.load(write(tmp_path, "cut.json", text[: len(text) // 2]))


def test_json_that_is_not_what_it_seems(tmp_path: Path) -> None:
    for text in ("", "[1, 2]", "{", '{"unit": "m", "objects": [[]]}', "\x00", "[" * 100_000):
        with pytest.raises(SceneFileError):
            Scene.load(write(tmp_path, "odd.json", text))
    (tmp_path / "latin.json").write_bytes(b'{"unit": "\xe4"}')
    with pytest.raises(SceneFileError, match="is not UTF-8"):
        Scene.load(tmp_path / "latin.json")
    rows = [[1e12, 0, 0, 1], [10**400, 0, 0, 1]]
    far = {"unit": "m", "objects": [{"name": "a", "spheres": rows}]}
    (tmp_path / "far.json").write_text(json.dumps(far))
    with pytest.raises(SceneFileError) as caught:
        Scene.load(tmp_path / "far.json")
    assert [fault.place for fault in caught.value.faults] == [
        "objects row 1 ('a'), spheres row 2",
        "objects row 1 ('a'), spheres row 1",
    ]


def test_the_example_scenes_are_what_their_script_makes(repo_root: Path, tmp_path: Path) -> None:
    folder = repo_root / "examples" / "scenes"
    script = runpy.run_path(str(repo_root / "examples" / "make_scenes.py"))
    script["main"](tmp_path)
    made = sorted(tmp_path.iterdir())
    assert [path.name for path in made] == ["crop.csv", "greenhouse.json"]
    for path in made:
        assert path.read_bytes() == (folder / path.name).read_bytes()
    sizes = {path.name: len(Scene.load(path)) for path in folder.glob("*.toml")}
    assert sizes == {"bench.toml": 6, "crop.toml": 4}
    greenhouse_file = Scene.load(folder / "greenhouse.json")
    assert_same(greenhouse_file, greenhouse(1, clear_band=(0.65, 1.3)))


# ---- objects and scenes made in Python ------------------------------------------------------


def test_objects_of_shapes_and_back() -> None:
    shapes = (
        Sphere((0, 0, 0.1), 0.05),
        Capsule((0, 0, 0), (0, 0, 1), 0.02),
        Box((1, 2, 3), (0.4, 0.5, 0.6), TURN, 0.01),  # type: ignore[arg-type]
        HalfSpace((0, 0, 1), -0.02),
        Convex(((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)), 0.03),
    )
    one = SceneObject.of("all", *shapes, kind="test", removable=True)
    assert one.shapes() == shapes
    assert len(one) == 5 and repr(one) == "SceneObject('all', kind='test', 5 solids)"
    pose = np.eye(4)
    pose[:3, :3] = TURN
    pose[:3, 3] = 1.0, -2.0, 0.5
    moved = one.moved(pose)
    for shape, expected in zip(moved.shapes(), shapes, strict=True):
        assert type(shape) is type(expected)
        back = np.linalg.inv(pose)
        np.testing.assert_allclose(
            _numbers(shape.moved(back)), _numbers(expected), atol=1e-15, rtol=0
        )
    with pytest.raises(ValueError, match="read-only"):
        one.spheres[0, 0] = 3.0


def _numbers(shape: Any) -> np.ndarray:
    return np.concatenate([np.ravel(value) for value in vars(shape).values()])


def test_wrong_shapes_are_named() -> None:
    nan = float("nan")
    for make, place in [
        (lambda: Sphere((0, 0, nan), 1), "centre"),
        (lambda: Sphere((0, 0, 0), -1), "radius"),
        (lambda: Sphere((0, 0), 1), "centre"),
        (lambda: Capsule((0, 0, 0), (0, 0, 1e10), 1), "b"),
        (lambda: Box((0, 0, 0), (1, 1, -1)), "half"),
        (lambda: Box((0, 0, 0), (1, 1, 1), np.diag([1, 1, 2])), "rotation"),
        (lambda: Box((0, 0, 0), (1, 1, 1), np.diag([1, 1, -1])), "rotation"),
        (lambda: Convex(()), "vertices"),
        (lambda: Convex(((0, 0, 0), (nan, 0, 0))), "vertices"),
        (lambda: HalfSpace((0, 0, 0), 1), "normal"),
        (lambda: HalfSpace((0, 0, 1), nan), "offset"),
        (lambda: Sphere((0, 0, 0), 1).moved(np.zeros((4, 4))), "pose"),
        (lambda: SceneObject.of("a", "sphere"), "shapes"),
        (lambda: SceneObject("", spheres=[[0, 0, 0, 1]]), "name"),
        (lambda: SceneObject("a", spheres=[[0, 0, 0, -1]]), "spheres of 'a'"),
        (lambda: SceneObject("a", spheres=[[0, 0, nan, 1]]), "spheres of 'a'"),
        (lambda: SceneObject("a", capsules=[[0, 0, 0, 1]]), "capsules of 'a'"),
        (lambda: SceneObject("a", boxes=[[0] * 16]), "boxes of 'a', row 1, rotation"),
        (lambda: SceneObject("a", hulls=[([[0, 0, nan]], 0)]), "hulls of 'a', row 1, vertices"),
        (lambda: SceneObject.cloud("a", [[0, 0, 0]], [1, 2]), "radius"),
        (lambda: SceneObject.cloud("a", [0, 0, 0], 1), "points"),
        (lambda: Target((0, 0, nan)), "point"),
        (lambda: Target((0, 0, 0), "fruit"), "objects"),
    ]:
        with pytest.raises(ArgumentError) as caught:
            make()  # type: ignore[no-untyped-call]
        assert caught.value.argument == place, caught.value


def test_names_of_a_scene_are_its_own() -> None:
    a, b = SceneObject("a"), SceneObject("b")
    with pytest.raises(ArgumentError, match="the name 'a', 'b' twice"):
        Scene([a, b, a, b, a])
    with pytest.raises(UnknownNameError, match="unknown object of an exemption 'c'"):
        Scene([a], exemptions=[("hand", "c")])
    with pytest.raises(UnknownNameError, match="unknown object of target 'T' 'c'"):
        Scene([a], targets={"T": Target((0, 0, 0), ("c",))})
    with pytest.raises(ArgumentError, match="exemptions"):
        Scene([a], exemptions=["ab"])
    with pytest.raises(ArgumentError, match="objects"):
        Scene(a)  # type: ignore[arg-type]
    scene = Scene([a, b], targets={"T": Target((0, 0, 0), ("a",))}, exemptions=[("hand", "a")])
    assert scene.without("a").names == ("b",)
    assert scene.without("a").targets["T"].objects == () and not scene.without("a").exemptions
    assert scene.with_objects(SceneObject("c")).names == ("a", "b", "c")
    with pytest.raises(ArgumentError, match="the name 'a' twice"):
        scene.with_objects(a)
    with pytest.raises(UnknownNameError, match="unknown object 'c'"):
        scene.without("c")
    with pytest.raises(UnknownNameError, match="unknown object 'c'"):
        scene["c"]
    assert scene.aiming_at("T").target == "T" and scene.target is None
    assert pickle.loads(pickle.dumps(scene.aiming_at("T"))).target == "T"
    assert scene.aiming_at("T").without("b").target == "T"
    with pytest.raises(UnknownNameError, match="unknown target 'U'"):
        scene.aiming_at("U")
    assert len(scene) == 2 and repr(scene) == "Scene(2 objects, 0 solids)"


def test_a_moved_scene_takes_its_targets_along() -> None:
    scene = greenhouse(1, 1, 1)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = TURN, (0.1, 0.2, 0.3)
    moved = scene.moved(pose)
    expected = np.array(TURN) @ scene.targets["F0_0"].point + pose[:3, 3]
    np.testing.assert_allclose(moved.targets["F0_0"].point, expected)
    assert moved.names == scene.names
