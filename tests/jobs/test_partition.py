"""The unit of work: idempotent, atomic, the same rows and bytes however it is cut and killed."""

import concurrent.futures
import dataclasses
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from agrik_fast import ArgumentError, Robot, Status
from agrik_fast.io import read_results, read_targets
from agrik_fast.jobs import (
    Assignment,
    Cancelled,
    FileSource,
    ForwardJob,
    JobError,
    SolveJob,
    _partition,
    open_store,
    run_partition,
    split_file,
)
from cluster_tools import ROBOT, hashes, pose_table, temporaries, write_parts

ROWS = 3_000
HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def arm() -> Robot:
    return Robot.load(ROBOT)


@pytest.fixture(scope="module")
def table() -> pyarrow.Table:
    return pose_table(ROWS)


def run_all(job: Any, source: FileSource, folder: Path) -> list[Any]:
    assignment, store = Assignment(job, source.check(job)), open_store(folder)
    store.prepare()
    return [
        run_partition(assignment, source.partition(k), store).record for k in range(source.count)
    ]


def joined(records: list[Any], folder: Path) -> Any:
    chunks = [read_results(folder / record.part)[1] for record in records]
    fields = dataclasses.fields(chunks[0])
    names = [field.name for field in fields if field.name not in ("scene", "extras")]
    assert all(chunk.scene is None and not chunk.extras for chunk in chunks)
    return {name: np.concatenate([getattr(chunk, name) for chunk in chunks]) for name in names}


@pytest.mark.parametrize("pieces", [1, 3, 7])
def test_any_partitioning_gives_the_rows_of_one_call(
    arm: Robot, table: pyarrow.Table, tmp_path: Path, pieces: int
) -> None:
    # Some that cannot be solved and some that are no numbers are rows like others.
    table = table.to_pandas()
    table.loc[::50, "x_m"] = 9.0
    table.loc[7, "qw"] = np.nan
    table = pyarrow.Table.from_pandas(table)
    parquet.write_table(table, tmp_path / "one.parquet")
    targets = read_targets(tmp_path / "one.parquet").read_all().targets
    expected = arm.ik(targets, seed=3, threads=2)
    source = FileSource(write_parts(tmp_path / "in", table, pieces))
    assert source.count == pieces and source.rows == ROWS
    records = run_all(SolveJob(arm, seed=3), source, tmp_path / "out")
    found = joined(records, tmp_path / "out")
    for name in ("q", "status", "success", "position_error", "iterations", "restarts"):
        assert np.array_equal(found[name], getattr(expected, name), equal_nan=name == "q"), name
    assert found["ids"].tolist() == list(range(1, ROWS + 1))
    counts = [sum(r.counts.get(status.name.lower(), 0) for r in records) for status in Status]
    assert counts == np.bincount(expected.status, minlength=len(Status)).tolist()
    assert [record.first for record in records] == [
        source.partition(k).first for k in range(pieces)
    ]


def test_a_large_file_is_cut_between_its_row_groups(
    arm: Robot, table: pyarrow.Table, tmp_path: Path
) -> None:
    parquet.write_table(table, tmp_path / "big.parquet", row_group_size=400)
    source = FileSource(tmp_path / "big.parquet", partition_rows=1_000)
    assert [source.partition(k).rows for k in range(source.count)] == [800, 800, 800, 600]
    assert source.partition(1).name == "big/000002"
    found = joined(run_all(SolveJob(arm), source, tmp_path / "out"), tmp_path / "out")
    whole = FileSource(tmp_path / "big.parquet")
    assert whole.count == 1 and whole.partition(0).name == "big"
    one = joined(run_all(SolveJob(arm), whole, tmp_path / "one"), tmp_path / "one")
    assert all(np.array_equal(found[name], one[name]) for name in one)


def test_bytes_do_not_depend_on_pieces_or_speed(
    arm: Robot, table: pyarrow.Table, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = FileSource(write_parts(tmp_path / "in", table, 1))
    monkeypatch.setattr(_partition, "BATCH_ROWS", 1_024)
    run_all(SolveJob(arm), source, tmp_path / "out")
    file = parquet.ParquetFile(tmp_path / "out" / "in-000.parquet")
    sizes = [file.metadata.row_group(k).num_rows for k in range(file.metadata.num_row_groups)]
    assert sizes == [1_024, 1_024, 952]
    for name, value in (("_PIECE_S", 1e-9), ("_FIRST_PIECE", 7)):
        monkeypatch.setattr(_partition, name, value)
    run_all(SolveJob(arm), source, tmp_path / "slow")
    assert hashes(tmp_path / "slow") == hashes(tmp_path / "out")


@pytest.mark.parametrize("text", [False, True])
def test_ids_go_with_their_rows(arm: Robot, tmp_path: Path, text: bool) -> None:
    table = pose_table(200)
    ids = [f"plant {k % 50}" if text else 10**12 - k for k in range(200)]
    table = table.append_column("id", pyarrow.array(ids))
    source = FileSource(write_parts(tmp_path / "in", table, 2))
    found = joined(run_all(SolveJob(arm), source, tmp_path / "out"), tmp_path / "out")
    assert found["ids"].tolist() == ids


def test_joint_values_forward_and_back(arm: Robot, tmp_path: Path) -> None:
    q = arm.random_q(500, seed=2)
    q[3, 0] = np.nan
    table = pyarrow.table({f"{name}_rad": q[:, k] for k, name in enumerate(arm.joint_names)})
    source = FileSource(write_parts(tmp_path / "in", table, 3))
    records = run_all(ForwardJob(arm), source, tmp_path / "poses")
    assert sum(record.counts["finite"] for record in records) == 499
    poses = FileSource(tmp_path / "poses")
    expected = arm.fk(q)
    targets = np.concatenate(
        [read_targets(tmp_path / "poses" / r.part).read_all().targets for r in records]
    )
    good = np.arange(500) != 3
    assert np.abs(targets[good] - expected[good]).max() < 1e-15
    found = joined(run_all(SolveJob(arm), poses, tmp_path / "back"), tmp_path / "back")
    assert found["status"].tolist() == [3 if k == 3 else 0 for k in range(500)]
    assert np.abs(arm.fk(found["q"][good]) - expected[good]).max() < 1e-5


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the program forks")
def test_killed_at_every_step(table: pyarrow.Table, tmp_path: Path) -> None:
    write_parts(tmp_path / "in", table.slice(0, 700), 1)
    words = [sys.executable, HERE / "kill_everywhere.py", tmp_path / "in", tmp_path / "out"]
    done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=100)
    assert done.returncode == 0, done.stderr
    lines = [line.split() for line in done.stdout.splitlines()]
    assert len(lines) == 8
    assert {line[1] for line in lines[:-1]} == {"-9"} and lines[-1][1] == "0"
    # The part is never there in part: first nothing, then all of it, then its record.
    seen = [line[2:] for line in lines]
    assert seen[0] == [] and seen[-3] == ["in-000.parquet"]
    assert seen[-2] == seen[-1] == ["in-000.parquet", "in-000.parquet.json"]
    arm = Robot.load(ROBOT)
    run_all(SolveJob(arm, seed=4), FileSource(tmp_path / "in"), tmp_path / "undisturbed")
    assert hashes(tmp_path / "out") == hashes(tmp_path / "undisturbed")
    # Every child that had begun to write left a file that nobody takes for a result.
    assert len(temporaries(tmp_path / "out")) >= len(lines) - 5


def once(source_place: str, target: str) -> str:
    source = FileSource(source_place)
    job = SolveJob(Robot.load(ROBOT))
    assignment = Assignment(job, source.check(job))
    return run_partition(assignment, source.partition(0), open_store(target)).record.sha256


def test_two_processes_at_the_same_partition(table: pyarrow.Table, tmp_path: Path) -> None:
    source = str(write_parts(tmp_path / "in", table, 1))
    # Threads share a process's number: their temporary files must differ all the same.
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        found = list(pool.map(once, [source] * 4, [str(tmp_path / "out")] * 4))
    assert len(set(found)) == 1
    assert list(hashes(tmp_path / "out").values()) == found[:1]
    assert temporaries(tmp_path / "out") == []


@pytest.fixture
def done(arm: Robot, table: pyarrow.Table, tmp_path: Path) -> tuple[Any, ...]:
    source = FileSource(write_parts(tmp_path / "in", table.slice(0, 300), 1))
    job = SolveJob(arm)
    assignment, store = Assignment(job, source.check(job)), open_store(tmp_path / "out")
    store.prepare()
    run_partition(assignment, source.partition(0), store)
    return assignment, source.partition(0), store, tmp_path / "out" / "in-000.parquet"


def edit(path: Path, **changes: Any) -> None:
    record = path.with_name(path.name + ".json")
    record.write_text(json.dumps(json.loads(record.read_text()) | changes))


@pytest.mark.parametrize(
    "harm",
    [
        lambda path: path.unlink(),
        lambda path: os.truncate(path, 1_000),
        lambda path: path.with_name(path.name + ".json").unlink(),
        lambda path: path.with_name(path.name + ".json").write_bytes(b"\xff[[[["),
        lambda path: edit(path, rows=299),
        lambda path: edit(path, job="0" * 64),
        lambda path: edit(path, check=None),
    ],
    ids=["missing", "truncated", "no record", "no JSON", "other rows", "other job", "no check"],
)
def test_what_is_not_as_recorded_is_done_again(
    done: tuple[Any, ...], harm: Callable[[Path], None]
) -> None:
    assignment, partition, store, path = done
    before = path.read_bytes()
    assert run_partition(assignment, partition, store).skipped
    harm(path)
    assert not run_partition(assignment, partition, store).skipped
    assert path.read_bytes() == before
    assert run_partition(assignment, partition, store).skipped


def test_a_changed_source_and_a_changed_job_are_done_again(
    done: tuple[Any, ...], arm: Robot
) -> None:
    assignment, partition, store, _ = done
    other = Assignment(SolveJob(arm, seed=1), assignment.columns)
    assert other.hash != assignment.hash
    assert not run_partition(other, partition, store).skipped
    assert not run_partition(assignment, partition, store).skipped
    touched = dataclasses.replace(partition, origin={**partition.origin, "modified_ns": 1})
    assert not run_partition(assignment, touched, store).skipped


@pytest.mark.parametrize("step", ["begin", "rows", "written"])
def test_what_is_given_up_leaves_nothing(
    arm: Robot, table: pyarrow.Table, tmp_path: Path, step: str
) -> None:
    source = FileSource(write_parts(tmp_path / "in", table, 1))
    job = SolveJob(arm)
    store = open_store(tmp_path / "out")
    store.prepare()

    def at_step(name: str) -> None:
        if name == step:
            raise Cancelled

    with pytest.raises(Cancelled):
        run_partition(Assignment(job, source.check(job)), source.partition(0), store, at_step)
    assert list((tmp_path / "out").iterdir()) == []


def test_a_disk_that_refuses_is_told_and_leaves_nothing(
    done: tuple[Any, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    assignment, partition, store, path = done
    path.unlink()

    def write(self: object, data: Any) -> int:
        raise OSError(28, "No space left on device")

    from agrik_fast.jobs import _store

    monkeypatch.setattr(_store.HashingStream, "write", write)
    with pytest.raises(JobError, match="cannot be written: no space left on device"):
        run_partition(assignment, partition, store)
    assert sorted(p.name for p in path.parent.iterdir()) == ["in-000.parquet.json"]


def test_other_instructions_than_the_jobs_are_refused(done: tuple[Any, ...]) -> None:
    assignment, partition, store, _ = done
    other = dataclasses.replace(assignment, simd="a512")
    with pytest.raises(JobError, match="the job a512; results would differ"):
        run_partition(other, partition, store)
    mixed = dataclasses.replace(assignment, simd="mixed")
    assert not run_partition(mixed, partition, store).skipped


def test_what_decides_results_is_in_the_hash(arm: Robot) -> None:
    columns = ("x_m", "y_m", "z_m")
    jobs = [
        SolveJob(arm),
        SolveJob(arm.with_tool(np.eye(4))),
        SolveJob(Robot.load("panda")),
        SolveJob(arm, task="position"),
        SolveJob(arm, solver="dls"),
        SolveJob(arm, seed=1),
        SolveJob(arm, position_tolerance=1e-5),
        SolveJob(arm, orientation_tolerance=1e-5),
        SolveJob(arm, tool_axis=(1.0, 0.0, 0.0)),
        SolveJob(arm, direction=(0.0, 0.0, 1.0)),
        SolveJob(arm, tool=np.eye(4)),
        ForwardJob(arm),
    ]
    every = {Assignment(job, columns).hash for job in jobs}
    every |= {Assignment(jobs[0], columns, simd="mixed").hash, Assignment(jobs[0], ("x",)).hash}
    assert len(every) == len(jobs) + 2
    # Who works and with how many threads decides nothing.
    assert Assignment(jobs[0], columns, threads=2).hash in every


def test_splitting_keeps_rows_and_ids(arm: Robot, tmp_path: Path) -> None:
    poses = arm.fk(arm.random_q(100, seed=1))
    np.savez(tmp_path / "t.npz", T=poses, id=np.array([f"row {k}" for k in range(100)]))
    files = split_file(tmp_path / "t.npz", tmp_path / "in", 40)
    assert [path.name for path in files] == [f"part-{k:06d}.parquet" for k in range(3)]
    chunks = [read_targets(path).read_all() for path in files]
    assert [len(chunk) for chunk in chunks] == [40, 40, 20]
    assert np.abs(np.concatenate([chunk.targets for chunk in chunks]) - poses).max() < 1e-15
    assert np.concatenate([chunk.ids for chunk in chunks])[99] == "row 99"
    with pytest.raises(JobError, match="exists already"):
        split_file(tmp_path / "t.npz", tmp_path / "in", 40)
    np.save(tmp_path / "p.npy", np.array([[1.0, 2.0, 3.0], [np.nan, 0.0, 0.0]]))
    (file,) = split_file(tmp_path / "p.npy", tmp_path / "points")
    assert read_targets(file).is_pose is False
    assert np.isnan(read_targets(file).read_all().targets[1, 0])


def test_arguments_of_jobs_are_named(arm: Robot) -> None:
    with pytest.raises(ArgumentError, match="`seed`"):
        SolveJob(arm, seed=-1)
    with pytest.raises(ArgumentError, match="`position_tolerance`"):
        SolveJob(arm, position_tolerance=0.0)
    source = pose_table(3).schema
    for job, words in (
        (SolveJob(arm, solver="lmm"), "unknown solver 'lmm'"),
        (SolveJob(arm, task="posed"), "unknown task 'posed'"),
        (SolveJob(arm, solver="ccd"), "ccd with orientations"),
    ):
        with pytest.raises(ArgumentError, match=words):
            job.columns(source, lambda reason: JobError("here", reason))
