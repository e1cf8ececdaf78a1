"""The same bytes from a Dask cluster, whoever is killed; collections and futures."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agrik_fast import ArgumentError, Robot, cluster
from agrik_fast.jobs import FileSource, ForwardJob, JobError, SolveJob
from cluster_tools import (
    ROBOT,
    Processes,
    ended,
    hashes,
    pose_table,
    processes,
    run_cluster,
    scheduler_address,
    temporaries,
    wait_for,
    write_formula,
    write_parts,
)

# Dask imports what has deprecated names on some versions of Python.
pytestmark = [
    pytest.mark.filterwarnings("default"),
    pytest.mark.skipif(sys.platform != "linux", reason="processes are found in /proc"),
]
PARTITIONS = 6


class Cluster(Processes):
    """A scheduler and two workers on this machine."""

    address = ""

    def begin(self, folder: Path, workers: int = 2) -> None:
        self.folder = folder
        file = folder / "scheduler.json"
        words = ("--host", "127.0.0.1", "--port", 0, "--no-dashboard", "--scheduler-file", file)
        self.scheduler = self.start("-m", "distributed.cli.dask_scheduler", *words)
        self.address = scheduler_address(file)
        for _ in range(workers):
            self.worker()

    def worker(self, level: str | None = None) -> subprocess.Popen[str]:
        """Start a worker, with an instruction set of its own if one is named."""
        more = {} if level is None else {"AGRIK_SIMD": level}
        words = ("--nthreads", 1, "--no-dashboard", "--host", "127.0.0.1")
        words += ("--memory-limit", "2GiB", "--local-directory", self.folder / "dask")
        return self.start("-m", "distributed.cli.dask_worker", self.address, *words, **more)

    def dask_workers(self) -> list[int]:
        return sorted(n for n, words in self.alive().items() if "multiprocessing.spawn" in words)


@pytest.fixture(scope="module")
def dask_cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    started = Cluster()
    try:
        started.begin(tmp_path_factory.mktemp("dask"))
        yield started
    finally:
        started.close()


@pytest.fixture(scope="module")
def formula(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_formula(tmp_path_factory.mktemp("formula") / "grid.toml")


@pytest.fixture(scope="module")
def undisturbed(formula: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    folder = tmp_path_factory.mktemp("undisturbed") / "out"
    run_cluster("solve", folder, "--generate", formula, "--robot", ROBOT, "--workers", 2)
    return hashes(folder)


def job(formula: Path, folder: Path, address: str, *more: object) -> tuple[object, ...]:
    options = ("--generate", formula, "--robot", ROBOT, "--scheduler", address)
    return ("solve", folder, *options, *more)


def parts(folder: Path) -> int:
    return len([path for path in folder.glob("*.json") if not path.name.startswith("_")])


@pytest.fixture
def run() -> Iterator[Processes]:
    with processes() as started:
        yield started


def test_a_killed_worker_costs_its_partition_and_nothing_else(
    dask_cluster: Cluster,
    run: Processes,
    formula: Path,
    undisturbed: dict[str, str],
    tmp_path: Path,
) -> None:
    folder = tmp_path / "out"
    driver = run.cluster(*job(formula, folder, dask_cluster.address))
    wait_for(lambda: any(name.startswith(".part-") for name in temporaries(folder)))
    os.kill(dask_cluster.dask_workers()[0], signal.SIGKILL)
    out, _ = ended(driver, 0)
    assert f"{PARTITIONS} partitions:" in out
    assert hashes(folder) == undisturbed
    wait_for(lambda: len(dask_cluster.dask_workers()) == 2)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGKILL, -9), (signal.SIGINT, 130)])
def test_a_driver_that_ends_leaves_the_cluster_idle(
    dask_cluster: Cluster,
    run: Processes,
    formula: Path,
    undisturbed: dict[str, str],
    tmp_path: Path,
    number: signal.Signals,
    code: int,
) -> None:
    folder = tmp_path / "out"
    driver = run.cluster(*job(formula, folder, dask_cluster.address))
    wait_for(lambda: parts(folder) >= 1 and temporaries(folder))
    driver.send_signal(number)
    _, err = ended(driver, code)
    assert run.gone() == {}
    # What was underway is given up by the workers, which clean up behind themselves.
    wait_for(lambda: not temporaries(folder), 30)
    there = parts(folder)
    assert 0 < there < PARTITIONS
    if code == 130:
        assert f"{there} of {PARTITIONS} partitions are there" in err or "go on with" in err
    out, _ = run_cluster(*job(formula, folder, dask_cluster.address))
    assert f"{there} were there" in out
    assert hashes(folder) == undisturbed


def test_a_killed_scheduler_is_told_and_the_job_goes_on_elsewhere(
    formula: Path, undisturbed: dict[str, str], tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    second = Cluster()
    try:
        second.begin(tmp_path, 1)
        driver = second.cluster(*job(formula, folder, second.address))
        wait_for(lambda: parts(folder) >= 1)
        second.scheduler.kill()
        second.scheduler.communicate()
        _, err = ended(driver, 4)
        assert "the scheduler does not answer any more" in err
        assert "partitions are there; go on with: agrik-fast cluster solve" in err
    finally:
        second.close()
    there = parts(folder)
    assert 0 < there < PARTITIONS
    out, _ = run_cluster("solve", folder, "--generate", formula, "-r", ROBOT, "--workers", 2)
    assert f"{there} were there" in out
    assert hashes(folder) == undisturbed


def test_workers_of_different_machines_are_refused(
    dask_cluster: Cluster, tmp_path: Path, formula: Path
) -> None:
    folder = tmp_path / "out"
    words = job(formula, folder, dask_cluster.address, "--simd", "scalar")
    _, err = run_cluster(*words, code=2)
    assert ", not scalar; start them with AGRIK_SIMD=scalar" in err
    other = dask_cluster.worker("scalar")
    wait_for(lambda: len(dask_cluster.dask_workers()) == 3)
    try:
        import distributed

        with distributed.Client(dask_cluster.address, set_as_default=False) as client:
            client.wait_for_workers(3, timeout=60)
        _, err = run_cluster(*job(formula, folder, dask_cluster.address), code=2)
        assert "mixed SIMD levels: " in err and "scalar (tcp://127.0.0.1:" in err
        assert "--allow-mixed" in err and not folder.exists()
    finally:
        other.terminate()
        other.communicate(timeout=60)
    wait_for(lambda: len(dask_cluster.dask_workers()) == 2)


@pytest.fixture
def client(dask_cluster: Cluster) -> Iterator[Any]:
    import distributed

    with distributed.Client(dask_cluster.address, set_as_default=False) as found:
        yield found


def test_futures_are_parts_that_a_run_finds(client: Any, tmp_path: Path) -> None:
    table = pose_table(2_000)
    source = write_parts(tmp_path / "in", table, 4)
    job = SolveJob(Robot.load(ROBOT), seed=2)
    found = cluster.futures(client, job, source, tmp_path / "out")
    records = [future.result().record for future in found]
    assert [record.first for record in records] == [
        FileSource(source).partition(k).first for k in range(4)
    ]
    end = cluster.solve(source, tmp_path / "out", ROBOT, seed=2, scheduler=client)
    assert (end.skipped, end.done, end.complete, end.rows) == (4, 0, True, 2_000)
    assert client.status == "running"


@pytest.mark.parametrize("known", [True, False])
def test_collections_get_the_answers_of_the_whole(client: Any, known: bool) -> None:
    import dask.dataframe

    frame = pose_table(600).to_pandas()
    frame.index = [f"row {k}" for k in range(600)]
    frame = frame.sort_index()
    rows = dask.dataframe.from_pandas(frame, npartitions=4)
    arm = Robot.load(ROBOT)
    lengths = [150] * 4 if known else None
    lazy = cluster.map_partitions(rows, SolveJob(arm, seed=6), lengths=lengths)
    found = client.compute(lazy, sync=True)
    poses = frame[["x_m", "y_m", "z_m"]].to_numpy()
    quats = frame[["qx", "qy", "qz", "qw"]].to_numpy()
    from agrik_fast.rotations import pose

    expected = arm.ik(pose(poses, quat=quats), seed=6)
    joints = [name for name in found.columns if name.endswith("_rad") and "error" not in name]
    assert np.array_equal(found[joints].to_numpy(), expected.q)
    assert found.index.tolist() == frame.index.tolist()
    assert found.columns.tolist() == lazy.columns.tolist()
    assert (found.status == "converged").all()


def test_arrays_and_wrong_collections(client: Any) -> None:
    import dask.array
    import dask.dataframe

    arm = Robot.load("puma560")
    q = arm.random_q(100, seed=1)
    names = [f"{name}_rad" for name in arm.joint_names]
    rows = dask.array.from_array(q, chunks=(30, 6))
    lazy = cluster.map_partitions(rows, ForwardJob(arm), columns=names)
    found = client.compute(lazy, sync=True)
    assert np.abs(found[["x_m", "y_m", "z_m"]].to_numpy() - arm.fk(q)[:, :3, 3]).max() == 0.0
    assert found.id.tolist() == list(range(1, 101))
    with pytest.raises(ArgumentError, match="`columns`"):
        cluster.map_partitions(rows, ForwardJob(arm), columns=names[:3])
    with pytest.raises(ArgumentError, match="a list"):
        cluster.map_partitions([], ForwardJob(arm))
    with pytest.raises(JobError, match="collection: missing column '"):
        cluster.map_partitions(rows, ForwardJob(arm), columns=list("abcdef"))
    frame = dask.dataframe.from_dask_array(rows, columns=names)
    with pytest.raises(ArgumentError, match="`lengths`: expected 4, got 2 numbers"):
        cluster.map_partitions(frame, ForwardJob(arm), lengths=[1, 2])


def test_a_scheduler_that_does_not_answer(formula: Path, tmp_path: Path) -> None:
    import socket

    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        words = job(formula, tmp_path / "out", address, "--timeout", 1)
        _, err = run_cluster(*words, code=2)
    assert f"{address}: the scheduler does not answer within 1 s" in err
    assert len(err.strip().splitlines()) == 1
    words = job(formula, tmp_path / "out", "tcp://127.0.0.1:9", "--timeout", 1)
    _, err = run_cluster(*words, code=2)
    assert "tcp://127.0.0.1:9: the scheduler does not answer within 1 s" in err
    assert not (tmp_path / "out").exists()
