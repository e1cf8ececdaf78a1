"""Columns that mean nothing to the solver, through partitions and through files cut into them."""

from __future__ import annotations

import datetime
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from agrik_fast import Robot, cluster
from agrik_fast.io import read_targets
from agrik_fast.jobs import (
    Assignment,
    FileSource,
    JobError,
    SolveJob,
    _partition,
    open_store,
    run_partition,
    split_file,
)

ROWS = 600


def targets(seed: int, **more: object) -> pyarrow.Table:
    """Return points with columns of several types, some with nulls."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(0.1, 0.4, (ROWS, 3))
    notes = [None if k % 7 == 0 else f"plant {k % 5}" for k in range(ROWS)]
    return pyarrow.table(
        {
            "row": pyarrow.array([None if k % 3 == 0 else k for k in range(ROWS)], pyarrow.int16()),
            **{name: points[:, k] for k, name in enumerate(("x_m", "y_m", "z_m"))},
            "note": pyarrow.array(notes).dictionary_encode(),
            "seen": [datetime.datetime(2026, 1, 1) + datetime.timedelta(k) for k in range(ROWS)],
            "ripe": rng.random(ROWS) < 0.5,
            "status": ["mine"] * ROWS,
            "shape": [[k] for k in range(ROWS)],
            **more,
        }
    )


def test_a_cluster_job_passes_them_on(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    tables = [targets(1), targets(2, bed=list(range(ROWS)))]
    for k, table in enumerate(tables):
        parquet.write_table(table, tmp_path / "in" / f"{k}.parquet")
    cluster.solve(tmp_path / "in", tmp_path / "out", "ur5", workers=1)
    for k, table in enumerate(tables):
        found = parquet.read_table(tmp_path / "out" / f"{k}.parquet")
        # Behind the result's own; not what some file lacks, what is nested or has an own name.
        assert found.column_names[-4:] == ["row", "note", "seen", "ripe"]
        assert found.schema.field("row").type == pyarrow.int16()
        for name in ("row", "note", "seen", "ripe"):
            assert found[name].to_pylist() == table[name].to_pylist(), name
        assert "bed" not in found.column_names and "shape" not in found.column_names
        assert set(found["status"].to_pylist()) <= {"converged", "out_of_reach", "not_found"}


def test_bytes_do_not_depend_on_pieces(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parquet.write_table(targets(3), tmp_path / "in.parquet")
    source = FileSource(tmp_path / "in.parquet")
    job = SolveJob(Robot.load("ur5")).passing_on(source.schema)
    assert job.passed_on == ("row", "note", "seen", "ripe")
    assignment = Assignment(job, source.check(job))
    for folder, piece in (("one", 64), ("other", 7)):
        monkeypatch.setattr(_partition, "_FIRST_PIECE", piece)
        monkeypatch.setattr(_partition, "_PIECE_S", 1e-9 if piece == 7 else 0.25)
        run_partition(assignment, source.partition(0), open_store(tmp_path / folder))
    one, other = ((tmp_path / folder / "in.parquet").read_bytes() for folder in ("one", "other"))
    assert one == other


def test_a_column_that_is_not_there_is_named(tmp_path: Path) -> None:
    parquet.write_table(targets(4), tmp_path / "in.parquet")
    source = FileSource(tmp_path / "in.parquet")
    with pytest.raises(JobError, match=r"no column 'mass' that can be passed on; found row, note"):
        source.check(SolveJob(Robot.load("ur5"), passed_on=("mass",)))


def test_a_file_that_is_cut_keeps_them(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text('id,x_m,y_m,z_m,note,mass\n7,0.1,0.2,0.3,"a, b",1.5\n9,0.2,0.2,0.3,ü,2\n')
    (file,) = split_file(path, tmp_path / "parts")
    found = read_targets(file).read_all()
    assert found.ids.tolist() == ["7", "9"]
    assert found.extras["note"].tolist() == ["a, b", "ü"]
    assert [float(mass) for mass in found.extras["mass"]] == [1.5, 2.0]
