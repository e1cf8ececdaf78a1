"""What is wrong is told in one line before anything starts."""

import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pyarrow
import pytest
from pyarrow import parquet

from agrik_fast import ArgumentError, cluster
from agrik_fast.jobs import JobError
from cluster_tools import ROBOT, hashes, pose_table, run_cluster, write_formula, write_parts


@pytest.fixture
def source(tmp_path: Path) -> Path:
    return write_parts(tmp_path / "in", pose_table(300), 3)


def refused(folder: Path, *words: object) -> str:
    """Return the line that a command is refused with; nothing may have been written."""
    before = hashes(folder) if folder.exists() else None
    out, err = run_cluster(*words, code=2)
    lines = err.strip().splitlines()
    assert out == "" and len(lines) == 1, (out, err)
    assert (hashes(folder) if folder.exists() else None) == before
    return lines[0].removeprefix("agrik-fast: ")


def solve(source: object, target: object, *more: object) -> tuple[object, ...]:
    return ("solve", source, target, "--robot", ROBOT, "--workers", 1, *more)


def rename(folder: Path, change: Callable[[pyarrow.Table], pyarrow.Table]) -> None:
    path = folder / "in-001.parquet"
    parquet.write_table(change(parquet.read_table(path)), path)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t: t.drop_columns(["z_m"]), "missing column 'z_m'; the files before have columns"),
        (
            lambda t: t.rename_columns(["x_mm", "y_mm", "z_mm", *t.column_names[3:]]),
            "columns x_mm (double), y_mm (double)",
        ),
        (
            lambda t: t.set_column(0, "x_m", t.column("x_m").cast("float")),
            "columns x_m (float), y_m (double)",
        ),
        (
            lambda t: t.append_column("id", pyarrow.array(range(t.num_rows))),
            "id (int64); the files before have columns x_m (double)",
        ),
        (
            lambda t: t.set_column(1, "y_m", pyarrow.array(["a"] * t.num_rows)),
            "column 'y_m' holds string, expected numbers; the files before",
        ),
    ],
)
def test_partitions_with_other_columns(
    source: Path, tmp_path: Path, change: Callable[[pyarrow.Table], pyarrow.Table], words: str
) -> None:
    rename(source, change)
    line = refused(tmp_path / "out", *solve(source, tmp_path / "out"))
    assert line.startswith(f"{source / 'in-001.parquet'}: ") and words in line
    assert not (tmp_path / "out").exists()


def test_columns_that_nobody_reads_may_differ(source: Path, tmp_path: Path) -> None:
    rename(source, lambda t: t.append_column("note", pyarrow.array(["x"] * t.num_rows)))
    assert cluster.solve(source, tmp_path / "out", ROBOT, workers=1).complete


def test_a_folder_of_another_job_or_source(source: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run_cluster(*solve(source, out))
    line = refused(out, *solve(source, out, "--tol", 1e-4, "--seed", 1))
    assert line == (
        f"{out}: holds results of another job: position_tolerance_m 1e-06, not 0.0001; seed 0, "
        "not 1; choose another folder, or replace them (force=True, --force)"
    )
    line = refused(out, "forward", source, out, "--robot", ROBOT)
    assert "missing column 'q1_rad'" in line
    other = write_parts(tmp_path / "other", pose_table(200), 2)
    line = refused(out, *solve(other, out))
    assert "holds results of another source: " in line and "partitions 3, not 2" in line
    (out / "_job.json").write_text("{")
    line = refused(out, *solve(source, out))
    assert line == f"{out}/_job.json: is damaged; remove it to go on"


def test_mixed_simd_levels(source: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    cluster.solve(source, out, ROBOT, workers=1, simd="scalar", shard=(0, 2))
    line = refused(out, *solve(source, out, "--simd", "avx2"))
    assert "mixed SIMD levels: holds results made with scalar, this machine uses avx2" in line
    assert "--allow-mixed" in line
    line = refused(out, *solve(source, out, "--simd", "avx2", "--allow-mixed"))
    assert "expected one of them, got 'avx2' and allow_mixed" in line
    end = cluster.solve(source, tmp_path / "mixed", ROBOT, workers=1, allow_mixed=True)
    assert end.complete
    # No machine has both of these.
    line = refused(tmp_path / "none", *solve(source, tmp_path / "none", "--simd", "sse9"))
    assert "unknown simd 'sse9'" in line


@pytest.mark.skipif(sys.platform == "win32", reason="permissions of POSIX")
def test_no_write_permission(source: Path, tmp_path: Path) -> None:
    shut = tmp_path / "shut"
    shut.mkdir(mode=0o555)
    words = [*map(str, solve(source, shut / "out"))]
    command = [sys.executable, "-m", "agrik_fast.cli", "cluster", *words]
    if os.geteuid() == 0:
        # The administrator may write everywhere but into what is no folder of files.
        words = [*map(str, solve(source, "/proc/agrik-fast"))]
        command = [sys.executable, "-m", "agrik_fast.cli", "cluster", *words]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 2, done.stderr
    assert "cannot be written: " in done.stderr and len(done.stderr.splitlines()) == 1
    assert list(shut.iterdir()) == []


def test_places_that_are_none(source: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").write_text("x")
    (tmp_path / "csv").mkdir()
    (tmp_path / "csv" / "t.csv").write_text("x_m,y_m,z_m\n0,0,0\n")
    for place, words in (
        (tmp_path / "none", "no such file or folder"),
        (tmp_path / "empty", "no .parquet file in it"),
        (tmp_path / "csv", "no .parquet file in it; found t.csv: cut other kinds with"),
        (tmp_path / "file", "is not a Parquet file"),
    ):
        line = refused(out, *solve(place, out))
        assert line.startswith(str(place)) and words in line
    damaged = source / "in-002.parquet"
    damaged.write_bytes(damaged.read_bytes()[:-9])
    line = refused(out, *solve(source, out))
    assert line.startswith(f"{damaged}: is not a Parquet file")
    damaged.unlink()
    for target in (source, source / "out"):
        assert "`OUT`: expected another folder" in refused(out, *solve(source, target))
    line = refused(out, *solve(source, tmp_path / "file"))
    assert line == f"{tmp_path / 'file'}: is a file, expected a folder"
    parquet.write_table(pose_table(3).slice(0, 0), tmp_path / "empty" / "a.parquet")
    assert "no rows in any file" in refused(out, *solve(tmp_path / "empty", out))
    assert "no such folder of results" in refused(out, "status", tmp_path / "none")
    for command in ("status", "verify", "clean"):
        line = refused(source, command, source)
        assert line == f"{source}: holds no results of a cluster job"


def test_options_are_named(source: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    formula = write_formula(tmp_path / "g.toml", 10, 5)
    for more, words in (
        (("--shard", "3/3"), "`--shard`: expected i/N, with i from 0 to N - 1, got '3/3'"),
        (("--shard", "1"), "`--shard`: expected i/N"),
        (("--shard", "0/2", "--scheduler", "tcp://127.0.0.1:1"), "a shard and a scheduler"),
        (("--scheduler", "nonsense"), "`--scheduler`: expected tcp://HOST:PORT"),
        (("--scheduler", "tcp://10.0.0.5:8786"), "tls:// for another machine"),
        (("--scheduler", "tls://10.0.0.5:8786"), "together with the files of TLS"),
        (("--tls-ca", "a.pem"), "`--tls-cert`: expected all of --tls-ca, --tls-cert, --tls-key"),
        (("--task", "posed"), "unknown task 'posed'"),
        (("--solver", "lmm"), "unknown solver 'lmm'"),
        (
            ("--tol", "0"),
            "`--tol`: expected a positive number, or three of which inf frees an axis, got 0.0",
        ),
        (("--generate", formula), "`paths`: expected OUT alone, with --generate, got 2"),
        (("--robot", "nobody"), "unknown robot 'nobody'"),
        (("--log", tmp_path / "no" / "log"), "`--log`: expected a file"),
    ):
        assert words in refused(out, *solve(source, out, *more)), more
    pem = (("--tls-ca", "a.pem"), ("--tls-cert", "b.pem"), ("--tls-key", "c.pem"))
    more = ("--scheduler", "tls://10.0.0.5:8786", *(word for pair in pem for word in pair))
    assert "`--tls-ca`: expected a PEM file, got 'a.pem'" in refused(
        out, *solve(source, out, *more)
    )
    assert "`paths`: expected IN and OUT, got 1" in refused(out, "solve", out, "-r", ROBOT)
    assert not out.exists()
    for options, words in (
        ({"workers": 0}, "`workers`"),
        ({"threads": True}, "`threads`"),
        ({"retries": -1}, "`retries`"),
        ({"shard": 3}, "`shard`: expected two whole numbers i, N"),
        ({"force": 1}, "`force`: expected True or False"),
        ({"generate": formula}, "`source`: expected a source or generate="),
        ({"tls": cluster.Tls("a", "b", "c")}, "`tls`"),
    ):
        with pytest.raises(ArgumentError) as caught:
            cluster.solve(source, out, ROBOT, **options)  # type: ignore[arg-type]
        assert words in str(caught.value)


def test_errors_travel_between_processes() -> None:
    for error in (JobError("a", "b"), cluster.LostError("a", "b")):
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is type(error) and str(again) == "a: b" and again.reason == "b"
