"""Target files: kinds, units, orientations, chunks and faults; results: test_results.py."""

import math
import pickle
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

import agrik_fast as ik
from agrik_fast import AgrikError
from agrik_fast.io import (
    TargetFileError,
    read_targets,
)

SUFFIXES = [".csv", ".npy", ".npz", ".parquet"]
# Rz(90 deg) Ry(45 deg) Rz(30 deg), worked out by hand.
H, Q = math.sqrt(0.5), math.sqrt(3.0) / 2.0
ZYZ_90_45_30 = np.array([[-0.5, -Q, 0.0], [H * Q, -H / 2.0, H], [-H * Q, H / 2.0, H]])


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def csv_file(folder: Path, text: str) -> Path:
    return write(folder / "targets.csv", text)


@pytest.mark.parametrize(
    "text",
    [
        "x_m,y_m,z_m\n0.426,-0.1,1e-3\n",
        "x_mm,y_mm,z_mm\n426,-100,1\n",
        "x_cm,y_cm,z_cm\n42.6,-10,0.1\n",
        "\ufeffz_m,x_m,y_m\r\n0.001,0.426,-0.1\r\n",
        "# a comment\n\n x_m , y_m ,z_m\n\n 0.426 , -0.1 , 0.001\n",
    ],
)
def test_csv_units_order_and_layout(tmp_path: Path, text: str) -> None:
    reader = read_targets(csv_file(tmp_path, text))
    chunk = reader.read_all()
    assert not reader.is_pose
    assert chunk.targets.tolist() == [[0.426, -0.1, 0.001]]
    assert chunk.ids.tolist() == [1]


@pytest.mark.parametrize(
    "columns",
    [
        {"zyz_alpha_deg": 90, "zyz_beta_deg": 45, "zyz_gamma_deg": 30},
        {
            "zyz_alpha_rad": math.pi / 2,
            "zyz_beta_rad": math.pi / 4,
            "zyz_gamma_rad": math.pi / 6,
        },
        {
            "roll_rad": math.atan2(H / 2, H),
            "pitch_rad": math.asin(H * Q),
            "yaw_rad": math.atan2(H * Q, -0.5),
        },
        {
            "roll_deg": math.degrees(math.atan2(H / 2, H)),
            "pitch_deg": math.degrees(math.asin(H * Q)),
            "yaw_deg": math.degrees(math.atan2(H * Q, -0.5)),
        },
        # Half angles: beta/2 with (alpha -+ gamma)/2.
        {
            "qx": -math.sin(math.pi / 8) * math.sin(math.pi / 6),
            "qy": math.sin(math.pi / 8) * math.cos(math.pi / 6),
            "qz": math.cos(math.pi / 8) * math.sin(math.pi / 3),
            "qw": math.cos(math.pi / 8) * math.cos(math.pi / 3),
        },
    ],
    ids=["zyz_deg", "zyz_rad", "rpy_rad", "rpy_deg", "quaternion"],
)
@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_orientations(tmp_path: Path, columns: dict[str, float], suffix: str) -> None:
    table = {"x_mm": 334.0, "y_mm": 471.0, "z_mm": 539.0, **columns}
    path = tmp_path / f"pose{suffix}"
    if suffix == ".csv":
        write(path, ",".join(table) + "\n" + ",".join(map(repr, table.values())) + "\n")
    else:
        parquet.write_table(pyarrow.table({key: [value] for key, value in table.items()}), path)
    reader = read_targets(path)
    pose = reader.read_all().targets[0]
    assert reader.is_pose
    assert pose[:3, 3].tolist() == [0.334, 0.471, 0.539]
    np.testing.assert_allclose(pose[:3, :3], ZYZ_90_45_30, atol=1e-15)
    assert pose[3].tolist() == [0, 0, 0, 1]


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("zyz_deg", [90.0, 45.0, 30.0]),
        ("rpy_rad", [math.atan2(H / 2, H), math.asin(H * Q), math.atan2(H * Q, -0.5)]),
    ],
)
def test_npz_position_and_angles(tmp_path: Path, key: str, value: list[float]) -> None:
    path = tmp_path / "pose.npz"
    ids = np.array(["left", "right"])
    points = np.array([[334, 471, 539], [0, 0, 1]])
    np.savez(path, position_mm=points, id=ids, q=np.zeros(2), **{key: np.array([value] * 2)})
    reader = read_targets(path)
    chunk = reader.read_all()
    assert (reader.count, reader.is_pose, reader.ignored) == (2, True, ("q",))
    assert chunk.targets[0, :3, 3].tolist() == [0.334, 0.471, 0.539]
    np.testing.assert_allclose(chunk.targets[1, :3, :3], ZYZ_90_45_30, atol=1e-15)
    assert chunk.ids.tolist() == ["left", "right"]


def test_arrays_of_points_and_poses(tmp_path: Path) -> None:
    points = np.arange(12, dtype=np.float32).reshape(4, 3)
    np.save(tmp_path / "points.npy", np.asfortranarray(points))
    poses = np.tile(np.eye(4), (5, 1, 1))
    np.save(tmp_path / "poses.npy", poses)
    np.savez(tmp_path / "poses.npz", T=poses)
    read = read_targets(tmp_path / "points.npy")
    assert read.count == 4
    chunk = read.read_all()
    assert chunk.targets.dtype == np.float64
    np.testing.assert_array_equal(chunk.targets, points)
    for name in ("poses.npy", "poses.npz"):
        read = read_targets(tmp_path / name)
        assert read.is_pose
        np.testing.assert_array_equal(read.read_all().targets, poses)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_chunks_are_the_whole_in_order(tmp_path: Path, suffix: str) -> None:
    points = np.random.default_rng(1).normal(size=(25, 3))
    path = tmp_path / f"points{suffix}"
    if suffix == ".csv":
        rows = "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in points.tolist())
        write(path, "x_m,y_m,z_m\n" + rows)
    elif suffix == ".npy":
        np.save(path, points)
    elif suffix == ".npz":
        np.savez(path, position_m=points)
    else:
        columns = {f"{axis}_m": points[:, k] for k, axis in enumerate("xyz")}
        parquet.write_table(pyarrow.table(columns), path, row_group_size=9)
    reader = read_targets(path)
    chunks = list(reader.chunks(10))
    assert all(len(chunk) <= 10 for chunk in chunks)
    assert [chunk.first for chunk in chunks] == np.cumsum([0, *map(len, chunks[:-1])]).tolist()
    np.testing.assert_array_equal(np.concatenate([chunk.targets for chunk in chunks]), points)
    assert np.concatenate([chunk.ids for chunk in chunks]).tolist() == list(range(1, 26))
    np.testing.assert_array_equal(reader.read_all().targets, points)


def test_ids_and_unused_columns(tmp_path: Path) -> None:
    path = csv_file(tmp_path, "note,x_m,y_m,z_m,id\nripe,1,2,3,007\ngreen,4,5,6,b2\n")
    reader = read_targets(path)
    assert reader.ignored == ("note",)
    assert reader.has_text_ids
    assert reader.read_all().ids.tolist() == ["007", "b2"]
    table = {"id": [9, 8], "x_m": [1, 2], "y_m": [1.0, None], "z_m": [0.0, 0.0]}
    parquet.write_table(pyarrow.table(table), tmp_path / "t.parquet")
    chunk = read_targets(tmp_path / "t.parquet").read_all()
    assert chunk.ids.tolist() == [9, 8]
    assert chunk.targets[0].tolist() == [1.0, 1.0, 0.0]
    assert math.isnan(chunk.targets[1, 1])


def test_rows_that_are_no_target_are_bad_input(tmp_path: Path) -> None:
    text = "x_m,y_m,z_m,qx,qy,qz,qw\n1,2,nan,0,0,0,1\n1,2,3,0,0,0,2\n1,2,3,0,0,0,0\n1,2,3,0,0,0,1\n"
    targets = read_targets(csv_file(tmp_path, text)).read_all().targets
    assert np.isfinite(targets).all(axis=(1, 2)).tolist() == [False, False, False, True]
    poses = np.tile(np.eye(4), (4, 1, 1))
    poses[1, 0, 0] = 1.01
    poses[2, 0, 0] = -1.0
    poses[3, 3, 3] = 2.0
    np.save(tmp_path / "poses.npy", poses)
    targets = read_targets(tmp_path / "poses.npy").read_all().targets
    # Matrices come as they are: which are none says the solver, as it is told to.
    np.testing.assert_array_equal(targets, poses)
    status = ik.Robot.load("redundant7").ik(targets).status
    assert (status == ik.Status.BAD_INPUT).tolist() == [False, True, True, True]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the file is empty"),
        ("# only a comment\n", "the file is empty"),
        ("x_m,y_m,z_m\n", "no targets after the header"),
        ("x_m,z_m\n1,2\n", "missing column 'y_m'"),
        ("a,b\n1,2\n", "missing column 'x_m'; expected x_m,y_m,z_m"),
        ("x_m,y_mm,z_m\n1,2,3\n", "mixed units in the position columns (x_m, y_mm, z_m)"),
        ("x,y,z\n1,2,3\n", "column 'x' names no unit, expected 'x_m' or 'x_cm' or 'x_mm'"),
        ("x_m,y_m,z_m,x_m\n1,2,3,4\n", "column 'x_m' appears twice"),
        ("x_m;y_m;z_m\n1;2;3\n", "columns are separated by ';', expected ','"),
        (
            "x_m,y_m,z_m\n1,2,3\n\n1,two,3\n",
            "row 2 (line 4), column 'y_m': expected a number, got 'two'",
        ),
        ("x_m,y_m,z_m\n1,,3\n", "row 1 (line 2), column 'y_m': expected a number, got ''"),
        ("x_m,y_m,z_m\n1,2\n", "row 1 (line 2): 2 fields, expected 3 as in the header"),
        ("x_m,y_m,z_m,qx,qy,qz\n1,2,3,0,0,0\n", "missing column 'qw' of the quaternion"),
        (
            "x_m,y_m,z_m,roll_deg,pitch_rad,yaw_deg\n1,2,3,0,0,0\n",
            "mixed units in the rpy orientation columns (roll_deg, pitch_rad, yaw_deg)",
        ),
        (
            "x_m,y_m,z_m,roll_deg,pitch_deg\n1,2,3,0,0\n",
            "missing column 'yaw_deg'",
        ),
        (
            "x_m,y_m,z_m,qx,qy,qz,qw,roll_deg,pitch_deg,yaw_deg\n1,2,3,0,0,0,1,0,0,0\n",
            "two orientations (quaternion and rpy), expected at most one",
        ),
    ],
)
def test_csv_faults_are_named(tmp_path: Path, text: str, message: str) -> None:
    path = csv_file(tmp_path, text)
    with pytest.raises(TargetFileError) as caught:
        read_targets(path).read_all()
    assert str(caught.value).startswith(f"{path}: {message}")
    assert "\n" not in str(caught.value)


def test_a_fault_beyond_the_first_chunk_names_its_row(tmp_path: Path) -> None:
    path = csv_file(tmp_path, "x_m,y_m,z_m\n" + "1,2,3\n" * 24 + "1,2,oops\n")
    with pytest.raises(TargetFileError, match=r"row 25 \(line 26\), column 'z_m'.*got 'oops'"):
        list(read_targets(path).chunks(10))


def test_csv_that_is_no_text(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_bytes(b"x_m,y_m,z_m\n\xff\xfe,1,2\n")
    with pytest.raises(TargetFileError, match="is not UTF-8 text"):
        read_targets(path).read_all()


def test_paths_that_are_no_target_file(tmp_path: Path) -> None:
    with pytest.raises(TargetFileError, match=r"unknown suffix '.xlsx', expected one of .csv"):
        read_targets(tmp_path / "t.xlsx")
    with pytest.raises(TargetFileError, match="cannot be read: no such file or directory"):
        read_targets(tmp_path / "t.csv")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(TargetFileError, match="is a folder, expected a file"):
        read_targets(tmp_path / "folder.csv")
    for suffix, message in [
        (".npy", "is not a NumPy array of numbers"),
        (".npz", "is not an NPZ file of plain arrays"),
        (".parquet", "is not a Parquet file"),
    ]:
        with pytest.raises(TargetFileError, match=message):
            read_targets(write(tmp_path / f"t{suffix}", "nonsense, but not empty"))


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.zeros((3, 4)), r"array of shape \(3, 4\), expected \(n, 3\) or \(n, 4, 4\)"),
        (np.zeros((0, 3)), "no targets in the array"),
        (np.array([["a", "b", "c"]]), "the array holds <U1, expected numbers"),
        (np.zeros((2, 3), dtype=complex), "the array holds complex128, expected numbers"),
    ],
)
def test_npy_faults_are_named(tmp_path: Path, array: np.ndarray, message: str) -> None:
    np.save(tmp_path / "t.npy", array)
    with pytest.raises(TargetFileError, match=message):
        read_targets(tmp_path / "t.npy")


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"p": np.zeros((2, 3))}, "missing key 'T' or 'position_m'; found p"),
        ({"position_m": np.zeros((2, 2))}, r"'position_m' of shape \(2, 2\), expected \(n, 3\)"),
        ({"T": np.zeros((2, 3))}, r"'T' of shape \(2, 3\), expected \(n, 4, 4\)"),
        (
            {"T": np.zeros((2, 4, 4)), "zyz_rad": np.zeros((2, 3))},
            r"two orientations \(T and zyz_rad\)",
        ),
        (
            {"position_m": np.zeros((2, 3)), "position_mm": np.zeros((2, 3))},
            r"two positions \(position_m and position_mm\)",
        ),
        (
            {"position_m": np.zeros((2, 3)), "quaternion_xyzw": np.zeros((2, 3))},
            r"'quaternion_xyzw' of shape \(2, 3\), expected \(2, 4\)",
        ),
        ({"position_m": np.zeros((2, 3)), "id": np.zeros(3, int)}, r"'id' of shape \(3,\)"),
        ({"position_m": np.zeros((2, 3)), "id": np.zeros(2)}, "'id' holds float64"),
        ({"position_m": np.array([["a"] * 3])}, "'position_m' holds <U1, expected numbers"),
        ({"position_m": np.zeros((0, 3))}, "no targets in the file"),
    ],
)
def test_npz_faults_are_named(tmp_path: Path, arrays: dict[str, np.ndarray], message: str) -> None:
    np.savez(tmp_path / "t.npz", **arrays)
    with pytest.raises(TargetFileError, match=message):
        read_targets(tmp_path / "t.npz")


def test_parquet_faults_are_named(tmp_path: Path) -> None:
    path = tmp_path / "t.parquet"
    for table, message in [
        ({"x_m": [1.0], "y_m": [2.0]}, "missing column 'z_m'"),
        ({"x_m": ["a"], "y_m": [2.0], "z_m": [3.0]}, "column 'x_m' holds string, expected numbers"),
        ({"x_m": [1.0], "y_m": [2.0], "z_m": [3.0], "id": [0.5]}, "column 'id' holds double"),
        ({"x_m": [1.0], "y_m": [None], "z_m": [3.0]}, "column 'y_m' holds null, expected numbers"),
    ]:
        parquet.write_table(pyarrow.table(table), path)
        with pytest.raises(TargetFileError, match=message):
            read_targets(path)
    empty = pyarrow.array([], "double")
    parquet.write_table(pyarrow.table(dict.fromkeys(["x_m", "y_m", "z_m"], empty)), path)
    with pytest.raises(TargetFileError, match="no targets in the file"):
        read_targets(path)


def test_file_errors_are_library_errors_and_travel() -> None:
    error = TargetFileError("a.csv", "is odd")
    assert isinstance(error, AgrikError)
    assert isinstance(error, ValueError)
    back = pickle.loads(pickle.dumps(error))
    assert (type(back), str(back), back.path, back.reason) == (
        TargetFileError,
        "a.csv: is odd",
        Path("a.csv"),
        "is odd",
    )
