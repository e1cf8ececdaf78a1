"""Labelled clouds: every kind of file, whole, damaged and cut off."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from agrik_fast.collision import Cloud, Scene, objects_of, read_cloud
from agrik_fast.errors import ArgumentError, SceneFileError

POINTS = np.array([[0.5, 0.25, 1.0], [0.5, 0.5, 1.25], [-2.0, 0.0, 0.75], [0.0, 0.125, 3.0]])
RADII = np.array([0.25, 0.5, 0.125, 0.0625])
LABELS = np.array([4, 7, 4, 9])


def ply(form: str) -> bytes:
    header = (
        f"ply\nformat {form} 1.0\ncomment made by hand\nelement vertex 4\n"
        "property float x\nproperty float y\nproperty double z\n"
        "property uchar red\nproperty float radius\nproperty int label\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()
    order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[form]
    rows = zip(POINTS.tolist(), RADII.tolist(), LABELS.tolist(), strict=True)
    if form == "ascii":
        lines = [f"{x} {y} {z} 12 {r} {k}" for (x, y, z), r, k in rows]
        return header + "\n".join([*lines, "3 0 1 2", ""]).encode()
    body = b"".join(struct.pack(f"{order}ffdBfi", *p, 12, r, k) for p, r, k in rows)
    return header + body + struct.pack(f"{order}Biii", 3, 0, 1, 2)


def packed(data: bytes) -> bytes:
    """Compress as LZF does: copies of what came before where there are some, else letters."""
    out, at = bytearray(), 0
    letters = bytearray()

    def flush() -> None:
        while letters:
            part = letters[:32]
            del letters[:32]
            out.extend([len(part) - 1, *part])

    while at < len(data):
        start = data.rfind(data[at : at + 3], max(0, at - 8192), at + 2) if at else -1
        if start < 0 or len(data) - at < 3:
            letters.append(data[at])
            at += 1
            continue
        length = 3
        while length < 264 and at + length < len(data):
            if data[start + length] != data[at + length]:
                break
            length += 1
        flush()
        back, rest = at - start - 1, length - 2
        if rest < 7:
            out.append(rest << 5 | back >> 8)
        else:
            out.extend([7 << 5 | back >> 8, rest - 7])
        out.append(back & 255)
        at += length
    flush()
    return bytes(out)


def pcd(form: str) -> bytes:
    header = (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
        "FIELDS x y z normal _ radius label\nSIZE 4 4 4 4 1 4 2\nTYPE F F F F U F U\n"
        f"COUNT 1 1 1 3 5 1 1\nWIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA {form}\n"
    ).encode()
    record = np.dtype(
        [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("normal", "<f4", 3), ("_", "u1", 5),
         ("radius", "<f4"), ("label", "<u2")]
    )  # fmt: skip
    rows = np.zeros(4, record)
    rows["x"], rows["y"], rows["z"] = POINTS.T
    rows["radius"], rows["label"] = RADII, LABELS
    if form == "ascii":
        text = [f"{x} {y} {z} 0 0 1 0 0 0 0 0 {r} {k}"
                for (x, y, z), r, k in zip(POINTS, RADII, LABELS, strict=True)]  # fmt: skip
        return header + "\n".join([*text, ""]).encode()
    if form == "binary":
        return header + rows.tobytes()
    columns = b"".join(np.ascontiguousarray(rows[name]).tobytes() for name in record.names or ())
    body = packed(columns)
    return header + struct.pack("<II", len(body), len(columns)) + body


def csv() -> bytes:
    rows = zip(POINTS, RADII, LABELS, strict=True)
    lines = [f"{x},{y},{z},grey,{r},{k}" for (x, y, z), r, k in rows]
    return "\n".join(["# made by hand", "X,y,z,colour,radius,label", *lines, ""]).encode()


def npz(folder: Path) -> bytes:
    np.savez(folder / "made.npz", points=POINTS, radius=RADII, labels=LABELS, more=np.zeros(3))
    return (folder / "made.npz").read_bytes()


KINDS: dict[str, Callable[[Path], bytes]] = {
    "text.ply": lambda _: ply("ascii"),
    "little.ply": lambda _: ply("binary_little_endian"),
    "big.ply": lambda _: ply("binary_big_endian"),
    "text.pcd": lambda _: pcd("ascii"),
    "binary.pcd": lambda _: pcd("binary"),
    "compressed.pcd": lambda _: pcd("binary_compressed"),
    "rows.csv": lambda _: csv(),
    "arrays.npz": npz,
}


def write(folder: Path, name: str, data: bytes | str) -> Path:
    path = folder / name
    path.write_bytes(data.encode() if isinstance(data, str) else data)
    return path


def fault(path: Path, **options: object) -> str:
    with pytest.raises(SceneFileError) as caught:
        read_cloud(path, **{"unit": "m", **options})
    assert caught.value.file == path.name
    return str(caught.value)


@pytest.mark.parametrize("name", KINDS)
def test_every_kind_reads_to_the_same(name: str, tmp_path: Path) -> None:
    path = write(tmp_path, name, KINDS[name](tmp_path))
    cloud = read_cloud(path, unit="m")
    np.testing.assert_array_equal(cloud.points, POINTS)
    np.testing.assert_array_equal(cloud.radii, RADII)
    assert cloud.labels is not None and cloud.labels.tolist() == LABELS.tolist()
    in_mm = read_cloud(path, unit="mm")
    np.testing.assert_array_equal(in_mm.points, POINTS / 1000.0)
    np.testing.assert_array_equal(in_mm.radii, RADII / 1000.0)


@pytest.mark.parametrize("name", KINDS)
def test_files_cut_off_anywhere_are_refused(name: str, tmp_path: Path) -> None:
    data = KINDS[name](tmp_path)
    whole = read_cloud(write(tmp_path, name, data), unit="m")
    lengths = range(0, len(data), max(1, len(data) // 150))
    refused = 0
    for length in lengths:
        path = write(tmp_path, f"cut-{name}", data[:length])
        try:
            found = read_cloud(path, unit="m")
        except SceneFileError:
            refused += 1
        else:
            # What is behind the points (faces, a last end of line) does not matter, and the
            # last digits of a text cannot be told from a shorter number. A CSV claims nothing:
            # it is as long as it is, but its rows are whole.
            if name.endswith(".csv"):
                assert data[:length].splitlines()[-1].count(b",") == 5
            elif name.startswith("text"):
                assert length > 0.6 * len(data) and len(found) == len(whole)
            else:
                np.testing.assert_array_equal(found.points, whole.points)
    assert refused > (0.4 if name.endswith(".csv") else 0.6) * len(lengths)


@pytest.mark.parametrize("name", KINDS)
def test_damaged_files_are_refused_or_read_but_never_a_traceback(name: str, tmp_path: Path) -> None:
    data = KINDS[name](tmp_path)
    random = np.random.default_rng(7)
    for _ in range(200):
        damaged = bytearray(data)
        for place in random.integers(0, len(data), 3):
            damaged[place] = random.integers(0, 256)
        try:
            cloud = read_cloud(write(tmp_path, name, bytes(damaged)), unit="m", radius=0.1)
        except SceneFileError:
            continue
        assert np.isfinite(cloud.points).all() and (cloud.radii >= 0).all()


@pytest.mark.parametrize("name", [name for name in KINDS if not name.endswith((".npz", ".csv"))])
def test_claims_are_held_against_the_bytes_that_are_there(name: str, tmp_path: Path) -> None:
    data = KINDS[name](tmp_path)
    for claim in (b"5", b"4000000000000"):
        more = data.replace(b"vertex 4", b"vertex " + claim)
        more = more.replace(b"POINTS 4", b"POINTS " + claim)
        words = fault(write(tmp_path, name, more))
        assert "claims" in words or "take" in words or "row 5" in words, words
    if name.startswith("text"):
        lines = data.rstrip(b"\n").split(b"\n")
        cut = b"\n".join(lines[:-2] if name.endswith("ply") else lines[:-1])
        words = fault(write(tmp_path, name, cut))
        assert "ends early: 3 of the 4" in words, words


def test_what_is_wrong_is_told_with_its_place(tmp_path: Path) -> None:
    head = "x,y,z,radius,label\n"
    for text, expected in [
        ("", "is empty, expected a line of names"),
        (head, "holds no points"),
        ("a,b\n1,2\n", "has no column x, y, z; found"),
        (head + "0,0,0,0.1,1\n0,0\n", "line 3: expected 5 fields, got 2, and the file ends"),
        (head + "0,0,zero,0.1,1\n", "line 2, z: expected a number, got 'zero'"),
        (head + "0,0,0,0.1,1\n0,nan,0,0.1,1\n", "point 2: expected finite numbers x, y, z"),
        (head + "0,0,0,-0.1,1\n", "point 1: expected a radius >= 0, got -0.1"),
        ("x,y,z\n0,0,0\n", "has no column 'radius', and no radius was given"),
        ("x,y,z,x\n0,0,0,1\n", "line 1: x twice"),
    ]:
        assert expected in fault(write(tmp_path, "c.csv", text)), text
    for data, expected in [
        (b"plx\n", "does not begin with 'ply'"),
        (b"ply\nformat ascii 1.0\n", "its header has no end"),
        (b"ply\nelement vertex 1\nend_header\n", "its header has no format"),
        (b"ply\nformat ascii 2.0\nend_header\n", "line 2: 'format ascii 2.0' is no line"),
        (b"ply\nformat ascii 1.0\nelement face 0\nend_header\n", "has no element 'vertex'"),
        (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar int a\nend_header\n1 2\n",
         "has lists before or among its vertices"),
    ]:  # fmt: skip
        assert expected in fault(write(tmp_path, "c.ply", data)), data
    sound = pcd("binary")
    for old, new, expected in [
        (b"DATA binary", b"DATA packed", "DATA 'packed', expected ascii, binary or"),
        (b"POINTS 4", b"POINTS four", "POINTS 'four', expected a whole number"),
        (b"SIZE 4 4 4 4", b"SIZE 4 3 4 4", "field 'y': type F 3 1 is unknown"),
        (b"COUNT 1 1 1 3", b"COUNT 1 1 1", "FIELDS, SIZE, TYPE and COUNT are not as many"),
        (b"POINTS 4\n", b"", "its header has no POINTS"),
        (b"WIDTH 2", b"BREADTH 2", "line 7: 'BREADTH 2' is no line of a PCD header"),
    ]:
        assert expected in fault(write(tmp_path, "c.pcd", sound.replace(old, new))), new
    np.savez(tmp_path / "c.npz", points=POINTS, radius=RADII[:3])
    assert "'radius' of shape (3,), expected (4,)" in fault(tmp_path / "c.npz")
    np.savez(tmp_path / "c.npz", where=POINTS)
    assert "has no array 'points'; found where" in fault(tmp_path / "c.npz")
    with pytest.raises(ArgumentError, match="which is no file"):
        read_cloud(tmp_path / "absent.ply", unit="m")
    with pytest.raises(ArgumentError, match=r"expected a .ply, .pcd, .npz, .csv file"):
        read_cloud(tmp_path / "c.las", unit="m")
    with pytest.raises(ArgumentError, match="unit"):
        read_cloud(tmp_path / "c.csv", unit="cm")
    with pytest.raises(TypeError, match="unit"):
        read_cloud(tmp_path / "c.csv")  # type: ignore[call-arg]


def test_points_that_a_camera_did_not_see_can_be_left_out(tmp_path: Path) -> None:
    path = write(tmp_path, "c.csv", "x,y,z,label\n0,0,1,a\nnan,nan,nan,a\n0,0,2,b\n")
    cloud = read_cloud(path, unit="m", radius=0.02, drop_nan=True)
    assert cloud.points[:, 2].tolist() == [1.0, 2.0]
    assert cloud.labels is not None and cloud.labels.tolist() == ["a", "b"]


def test_labels_become_objects() -> None:
    cloud = Cloud(POINTS, RADII, LABELS)
    objects = objects_of(cloud, names={4: "leaf", "9": "stem"}, kind="crop", removable=True)
    assert [(one.name, len(one), one.kind, one.removable) for one in objects] == [
        ("leaf", 2, "crop", True),
        ("cloud_7", 1, "crop", True),
        ("stem", 1, "crop", True),
    ]
    np.testing.assert_array_equal(objects[0].spheres, np.column_stack([POINTS, RADII])[[0, 2]])
    (whole,) = objects_of(Cloud(POINTS, 0.1), name="crop")
    assert (whole.name, len(whole)) == ("crop", 4)
    for wrong, place in [
        ({"points": POINTS[:, :2]}, "points"),
        ({"points": POINTS * np.nan}, "points"),
        ({"radii": RADII[:2]}, "radii"),
        ({"radii": -RADII}, "radii"),
        ({"labels": LABELS[:2]}, "labels"),
        ({"labels": RADII}, "labels"),
    ]:
        with pytest.raises(ArgumentError) as caught:
            Cloud(**{"points": POINTS, "radii": RADII, "labels": LABELS, **wrong})
        assert caught.value.argument == place


def test_clouds_beside_a_scene_file(tmp_path: Path) -> None:
    write(tmp_path, "crop.pcd", pcd("binary"))
    write(
        tmp_path,
        "scene.toml",
        'unit = "mm"\nexemptions = [["hand", "leaf"]]\n'
        '[[clouds]]\nfile = "crop.pcd"\nunit = "m"\nnames = { 4 = "leaf" }\nkind = "leaf"\n'
        '[[objects]]\nname = "post"\ncapsules = [[0, 0, 0, 0, 0, 1000, 20]]\n',
    )
    scene = Scene.load(tmp_path / "scene.toml")
    assert scene.names == ("post", "leaf", "cloud_7", "cloud_9")
    assert scene["leaf"].spheres[:, 3].tolist() == [0.25, 0.125]
    text = (tmp_path / "scene.toml").read_text()
    write(tmp_path, "bad.toml", text.replace("crop.pcd", "crap.pcd"))
    with pytest.raises(SceneFileError, match=r"clouds row 1 \('crap.pcd'\).*which is no file"):
        Scene.load(tmp_path / "bad.toml")
    write(tmp_path, "crop.pcd", pcd("binary")[:-3])
    with pytest.raises(SceneFileError, match=r"clouds row 1 \('crop.pcd'\).*3 of the 4 points"):
        Scene.load(tmp_path / "scene.toml")
    write(tmp_path, "crop.pcd", pcd("binary"))
    write(tmp_path, "bad.toml", text.replace('"hand", "leaf"', '"hand", "loaf"'))
    with pytest.raises(SceneFileError, match="loaf"):
        Scene.load(tmp_path / "bad.toml")


def test_a_million_points(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    points = random.random((1_000_000, 3))
    labels = random.integers(0, 9, len(points))
    np.savez(tmp_path / "many.npz", points=points, radius=0.001, labels=labels)
    cloud = read_cloud(tmp_path / "many.npz", unit="m")
    objects = objects_of(cloud)
    assert sum(map(len, objects)) == 1_000_000 and len(objects) == 9
    np.testing.assert_array_equal(objects[0].spheres[0, :3], points[0])
