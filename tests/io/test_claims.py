"""What files claim and how far they are believed; one tolerance for files and calls."""

import io
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from agrik_fast import Robot, Status, Warnings
from agrik_fast import _npy as npy
from agrik_fast.io import (
    ResultFileError,
    TargetFileError,
    open_results,
    read_results,
    read_targets,
)
from agrik_fast.io import _reader as reader_module
from agrik_fast.io._records import ResultChunk, ResultLayout
from agrik_fast.jobs import SolveRequest, solve_file

UR5 = Robot.load("ur5")


def skewed(defects: list[float]) -> np.ndarray:
    """Return reachable poses, each with one entry of its rotation off by so much."""
    poses = UR5.fk(UR5.random_q(len(defects), seed=3))
    scale = np.sqrt(1.0 + np.array(defects))
    poses[:, :3, 0] *= scale[:, None]
    return poses


@pytest.mark.parametrize("suffix", [".npy", ".npz"])
def test_files_and_calls_treat_rows_that_are_not_rigid_alike(tmp_path: Path, suffix: str) -> None:
    poses = skewed([0.0, 9e-7, 1.1e-6, -2e-6, 9e-6, 1e-5, 2e-5, 1e-4, 9e-4, 1e-3, 0.1, 0.0])
    poses[-1, 3, 0] = 1e-12
    path, output = tmp_path / f"t{suffix}", tmp_path / f"r{suffix}"
    np.save(path, poses) if suffix == ".npy" else np.savez(path, T=poses)
    solve_file(SolveRequest(robot="ur5", targets=path, output=output, solver="auto"))
    _, rows = read_results(output)
    bad = [*[False] * 10, True, True]
    assert (rows.status == Status.BAD_INPUT).tolist() == bad
    direct = UR5.ik(poses, solver="auto")
    np.testing.assert_array_equal(rows.q, direct.q)
    straight = [False, False, *[True] * 8, False, False]
    assert (direct.warnings == Warnings.STRAIGHTENED).tolist() == straight


@pytest.mark.parametrize("suffix", [".npy", ".npz"])
@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("kind", ["<f8", ">f8", "<f4", "<i2"])
def test_arrays_of_any_order_are_streams(
    tmp_path: Path, suffix: str, order: str, kind: str
) -> None:
    poses = np.round(UR5.fk(UR5.random_q(50, seed=1)) * 100)
    poses[:, :3, :3], poses[:, 3] = np.eye(3), (0, 0, 0, 1)
    for array, key in ((poses, "T"), (poses[:, :3, 3], "position_m")):
        stored = np.array(array, dtype=kind, order=order)  # type: ignore[call-overload]
        path = tmp_path / f"{key}{suffix}"
        np.save(path, stored) if suffix == ".npy" else np.savez(path, **{key: stored})
        parts = list(read_targets(path).chunks(7))
        assert [len(part) for part in parts] == [7] * 7 + [1]
        np.testing.assert_array_equal(np.concatenate([part.targets for part in parts]), array)


def test_chunks_are_bounded_by_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agrik_fast.io._csv_targets.CHUNK_BYTES", 40_000)
    monkeypatch.setattr(reader_module, "CHUNK_BYTES", 40_000)
    ids = ["short"] * 30 + ["w" * 1000] + ["short"] * 30
    csv = "id,x_m,y_m,z_m\n" + "".join(f"{each},1,2,3\n" for each in ids)
    (tmp_path / "t.csv").write_text(csv)
    columns = {f"{axis}_m": np.ones(61) for axis in "xyz"}
    parquet.write_table(pyarrow.table({"id": ids, **columns}), tmp_path / "t.parquet")
    np.savez(tmp_path / "t.npz", position_m=np.ones((61, 3)), id=np.array(ids))
    for suffix in ("csv", "parquet", "npz"):
        chunks = list(read_targets(tmp_path / f"t.{suffix}").chunks())
        assert len(chunks) > 1
        assert max(chunk.ids.nbytes for chunk in chunks) < 150_000
        assert np.concatenate([chunk.ids for chunk in chunks]).tolist() == ids
        assert [chunk.first for chunk in chunks[1:]] == np.cumsum(
            [len(chunk) for chunk in chunks[:-1]]
        ).tolist()


def test_long_ids_are_refused_with_their_row(tmp_path: Path) -> None:
    long = "x" * 1001
    (tmp_path / "t.csv").write_text(f"id,x_m,y_m,z_m\na,1,2,3\n{long},1,2,3\n")
    columns = {f"{axis}_m": np.ones(2) for axis in "xyz"}
    parquet.write_table(pyarrow.table({"id": ["a", long], **columns}), tmp_path / "t.parquet")
    np.savez(tmp_path / "t.npz", position_m=np.ones((2, 3)), id=np.array(["a", long]))
    for name, place in [
        ("t.csv", r"row 2 \(line 3\), column 'id': 1001 letters"),
        ("t.parquet", "row 2, column 'id': 1001 letters"),
        ("t.npz", "'id' holds text of 1001 letters"),
    ]:
        with pytest.raises(TargetFileError, match=f"{name}: {place}, expected at most 1000"):
            read_targets(tmp_path / name).read_all()


def test_text_ids_of_a_parquet_file_in_a_fresh_process(tmp_path: Path) -> None:
    columns = {f"{axis}_m": np.full(3, 0.2) for axis in "xyz"}
    ids = ["a", "b", "i" * 900]
    parquet.write_table(pyarrow.table({"id": ids, **columns}), tmp_path / "t.parquet")
    command = [sys.executable, "-m", "agrik_fast.cli", "solve", "ur5", "t.parquet", "-o", "r.npz"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    assert read_results(tmp_path / "r.npz")[1].ids.tolist() == ids


def archive(path: Path, data: bytes, method: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", method) as out:
        out.writestr("position_m.npy", data)
    return path


def saved(array: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def test_archives_are_not_believed(tmp_path: Path) -> None:
    whole = saved(np.zeros((4, 3)))
    claims = whole.replace(b"(4, 3)", b"(9, 3)")
    for data, method, message in [
        (claims, zipfile.ZIP_DEFLATED, r"'position_m': is damaged: shape \(9, 3\) needs 344 bytes"),
        (whole, zipfile.ZIP_LZMA, "compression method 14, expected 0"),
        (b"PK" + whole, zipfile.ZIP_STORED, "no NPY header"),
        (saved(np.zeros((3_000_000, 3))), zipfile.ZIP_DEFLATED, "more than 500 times as many"),
    ]:
        with pytest.raises(TargetFileError, match=message):
            read_targets(archive(tmp_path / "t.npz", data, method)).read_all()
    path = archive(tmp_path / "t.npz", whole, zipfile.ZIP_STORED)
    # A bit of the numbers: only the archive's checksum knows.
    path.write_bytes(path.read_bytes().replace(bytes(90), bytes(89) + b"\x01"))
    with pytest.raises(TargetFileError, match=r"t\.npz: 'position_m': is damaged: Bad CRC-32"):
        read_targets(path).read_all()


def test_numbers_that_no_float_holds_are_named(tmp_path: Path) -> None:
    table = {"x_m": [1, 2**60 + 1], "y_m": [1, 2], "z_m": [1, 2]}
    parquet.write_table(pyarrow.table(table), tmp_path / "t.parquet")
    with pytest.raises(TargetFileError, match=r"t\.parquet: row 2, column 'x_m': expected a num"):
        read_targets(tmp_path / "t.parquet").read_all()
    ids = np.array([1, 2**63], dtype=np.uint64)
    np.savez(tmp_path / "t.npz", position_m=np.ones((2, 3)), id=ids)
    with pytest.raises(TargetFileError, match=r"t\.npz: row 2, 'id': is beyond 2\*\*63 - 1"):
        read_targets(tmp_path / "t.npz").read_all()


def test_endless_rows_and_quotes_are_refused_where_they_begin(tmp_path: Path) -> None:
    head = "x_m,y_m,z_m\n1,2,3\n"
    for text, message in [
        (head + '"' + "1,2,3\n" * 300_000, "line 3: a row of more than 1048576 letters"),
        (head + "1" * 1_200_000, "line 3: a row of more than 1048576 letters"),
        (head + '"a\nb",' * 300_000, "line 3: a row of more than 1048576 letters"),
    ]:
        (tmp_path / "t.csv").write_text(text)
        with pytest.raises(TargetFileError, match=rf"t\.csv: {message}"):
            read_targets(tmp_path / "t.csv").read_all()
    (tmp_path / "t.csv").write_bytes(head.encode() + b"1,2,3\n" * 5998 + b"\xff,1,2\n")
    with pytest.raises(TargetFileError, match="line 6001: is not UTF-8 text"):
        read_targets(tmp_path / "t.csv").read_all()


@pytest.mark.parametrize("suffix", [".csv", ".npy", ".npz", ".parquet"])
@pytest.mark.parametrize("joint", ["theta_rad", "θ_rad", "a" * 900 + "_rad"])
def test_results_with_any_names_read_back(tmp_path: Path, suffix: str, joint: str) -> None:
    chunk = ResultChunk(
        ids=np.array([7, 8]),
        q=np.array([[0.5], [1.5]]),
        status=np.array([0, 2], dtype=np.int8),
        success=np.array([True, False]),
        position_error=np.zeros(2),
        orientation_error=np.zeros(2),
        iterations=np.zeros(2, dtype=np.int32),
        restarts=np.zeros(2, dtype=np.int32),
    )
    path = tmp_path / f"r{suffix}"
    with open_results(path, ResultLayout((joint,))) as writer:
        writer.write(chunk)
    layout, rows = read_results(path)
    assert layout.joint_columns == (joint,)
    np.testing.assert_array_equal(rows.q, chunk.q)
    if suffix == ".npy":
        loaded = np.load(path, max_header_size=100_000)
        assert loaded["id"].tolist() == [7, 8]


def test_results_with_codes_that_do_not_exist_are_refused(tmp_path: Path) -> None:
    points = UR5.fk(UR5.random_q(5, seed=1))[:, :3, 3]
    np.save(tmp_path / "t.npy", points)
    solve_file(SolveRequest(robot="ur5", targets=tmp_path / "t.npy", output=tmp_path / "r.npy"))
    rows = np.load(tmp_path / "r.npy")
    rows["status"][3] = 77
    np.save(tmp_path / "r.npy", rows)
    with pytest.raises(
        ResultFileError, match="row 4, 'status': expected a code from 0 to 11, got 77"
    ):
        read_results(tmp_path / "r.npy")


def test_headers_are_as_long_for_any_count() -> None:
    dtype = np.dtype([("id", "<i8"), ("θ", "<f8")])
    lengths = {len(npy.header_bytes(dtype, rows)) for rows in (0, 1, 10**9, 10**18)}
    assert len(lengths) == 1 and lengths.pop() % 64 == 0
    data = npy.header_bytes(dtype, 2) + bytes(32)
    assert np.load(io.BytesIO(data)).shape == (2,)
