"""The same in an object store: parts named by their content, records that point to them."""

import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from agrik_fast import cluster
from agrik_fast.jobs import (
    Assignment,
    Cancelled,
    FileSource,
    JobError,
    SolveJob,
    load_robot,
    open_store,
    run_partition,
)
from cluster_tools import (
    ROBOT,
    Processes,
    ended,
    hashes,
    pose_table,
    processes,
    run_cluster,
    wait_for,
    write_formula,
    write_parts,
)

# What the store's libraries say of their own and of each other's names.
pytestmark = [
    pytest.mark.filterwarnings("default"),
    pytest.mark.skipif(sys.platform != "linux", reason="processes are found in /proc"),
]
PARTITIONS = 4


@pytest.fixture(scope="module")
def store() -> Iterator[str]:
    """Start a store on this machine, which this process and its children use."""
    from moto.server import ThreadedMotoServer

    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    more = {
        "AWS_ENDPOINT_URL": f"http://{host}:{port}",
        "AWS_ACCESS_KEY_ID": "nobody",
        "AWS_SECRET_ACCESS_KEY": "nothing",
        "AWS_DEFAULT_REGION": "us-east-1",
    }
    before = {name: os.environ.get(name) for name in more}
    os.environ.update(more)
    try:
        yield "s3://results"
    finally:
        server.stop()
        for name, value in before.items():
            if value is None:
                os.environ.pop(name)
            else:
                os.environ[name] = value


@pytest.fixture(scope="module")
def files(store: str) -> Any:
    import s3fs

    found = s3fs.S3FileSystem(use_listings_cache=False)
    found.mkdir("results")
    return found


@pytest.fixture
def run() -> Iterator[Processes]:
    with processes() as started:
        yield started


@pytest.fixture(scope="module")
def formula(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_formula(tmp_path_factory.mktemp("formula") / "grid.toml", 1_200, 300)


@pytest.fixture(scope="module")
def undisturbed(formula: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return the hashes of the same job's results in a folder."""
    folder = tmp_path_factory.mktemp("undisturbed") / "out"
    run_cluster(*job(formula, folder))
    return {name.removesuffix(".parquet"): value for name, value in hashes(folder).items()}


def job(formula: Path, place: object, *more: object) -> tuple[object, ...]:
    options = ("--generate", formula, "--robot", ROBOT, "--workers", 1)
    return ("solve", place, *options, *more)


def same(files: Any, place: str, undisturbed: dict[str, str]) -> bool:
    """Return whether all parts in a store are those of the folder, and their names say so."""
    import hashlib

    root = place.removeprefix("s3://") + "/_parts/"
    found = {}
    for path in files.find(root):
        name, _, mark = path[len(root) :].removesuffix(".parquet").rpartition("-")
        found[name] = hashlib.sha256(files.cat_file(path)).hexdigest()
        assert found[name].startswith(mark)
    expected = {name: each for name, each in undisturbed.items() if name != "_manifest.json"}
    return found == expected and files.exists(f"{place}/_manifest.json")


def records(files: Any, place: str) -> int:
    return len(files.find(f"{place}/_records"))


def test_worker_and_driver_killed(
    run: Processes, files: Any, store: str, formula: Path, undisturbed: dict[str, str]
) -> None:
    place = f"{store}/killed"
    driver = run.cluster(*job(formula, place))
    wait_for(lambda: run.workers() and files.exists(f"{place}/_job.json"))
    os.kill(run.workers()[0], signal.SIGKILL)
    wait_for(lambda: records(files, place) >= 2)
    driver.kill()
    driver.communicate()
    assert run.gone() == {}
    there = records(files, place)
    assert there < PARTITIONS
    out, _ = run_cluster("status", place, code=4)
    assert out.startswith(f"{there} of {PARTITIONS} partitions")
    out, _ = run_cluster(*job(formula, place))
    assert f"{there} were there" in out
    assert same(files, place, undisturbed)


def test_ctrl_c_then_shards(
    run: Processes, files: Any, store: str, formula: Path, undisturbed: dict[str, str]
) -> None:
    place = f"{store}/stopped"
    driver = run.cluster(*job(formula, place))
    wait_for(lambda: records(files, place) >= 1)
    driver.send_signal(signal.SIGINT)
    _, err = ended(driver, 130)
    assert "go on with: agrik-fast cluster solve" in err
    assert run.gone(1.0) == {}
    for k in range(2):
        out, _ = run_cluster(*job(formula, place, "--shard", f"{k}/2"))
    assert "other shards" not in out
    assert same(files, place, undisturbed)


def test_truncated_flipped_and_changed(
    files: Any, store: str, formula: Path, undisturbed: dict[str, str]
) -> None:
    place = f"{store}/harmed"
    run_cluster(*job(formula, place))
    assert same(files, place, undisturbed)
    parts = sorted(files.find(f"{place}/_parts"))
    files.pipe_file(parts[0], files.cat_file(parts[0])[:-1])
    files.rm_file(parts[1])
    data = bytearray(files.cat_file(parts[2]))
    data[len(data) // 2] ^= 1
    files.pipe_file(parts[2], bytes(data))
    out, _ = run_cluster("verify", place, code=4)
    assert f"{Path(parts[2]).name}: is not what was written" in out and "3 damaged" in out
    out, _ = run_cluster(*job(formula, place))
    assert f"3 done, {PARTITIONS - 3} were there" in out
    assert same(files, place, undisturbed)
    _, err = run_cluster(*job(formula, place, "--seed", 5), code=2)
    assert f"{place}: holds results of another job: seed 0, not 5" in err
    run_cluster(*job(formula, place, "--seed", 5, "--force"))
    assert not same(files, place, undisturbed)
    # Parts of the former job are gone: nobody reads them by listing the folder.
    assert len(files.find(f"{place}/_parts")) == PARTITIONS


def test_an_upload_that_is_given_up_is_never_seen(files: Any, store: str, tmp_path: Path) -> None:
    source = FileSource(write_parts(tmp_path / "in", pose_table(300), 1))
    job = SolveJob(load_robot(ROBOT))
    target = open_store(f"{store}/given-up")
    target.prepare()

    def at_step(step: str) -> None:
        if step == "written":
            raise Cancelled

    with pytest.raises(Cancelled):
        run_partition(Assignment(job, source.check(job)), source.partition(0), target, at_step)
    assert files.find(f"{store}/given-up") == []

    class Broken:
        def __init__(self) -> None:
            self.pieces = [b"x" * 100, OSError("the disk is gone")]

        def read(self, size: int) -> bytes:
            piece = self.pieces.pop(0)
            if isinstance(piece, Exception):
                raise piece
            return piece

    with pytest.raises(JobError, match="cannot be written"):
        target.send("_parts/half.parquet", Broken())  # type: ignore[attr-defined]
    assert files.find(f"{store}/given-up") == []


def test_from_a_store_to_a_store_and_on(files: Any, store: str, tmp_path: Path) -> None:
    folder = write_parts(tmp_path / "in", pose_table(600), 3)
    for path in folder.iterdir():
        files.put_file(str(path), f"results/in/{path.name}")
    end = cluster.solve(f"{store}/in", f"{store}/solved", ROBOT, workers=1)
    assert end.complete and end.rows == 600 and end.counts == {"converged": 600}
    assert cluster.status(f"{store}/solved").complete
    end = cluster.forward(f"{store}/solved", tmp_path / "poses", ROBOT, workers=1)
    assert end.complete and end.counts == {"bad_input": 0, "finite": 600}
    # Another content of the same size and name is another source.
    files.put_file(str(folder / "in-001.parquet"), "results/in/in-000.parquet")
    end = cluster.solve(f"{store}/in", f"{store}/solved", ROBOT, workers=1, force=True)
    assert end.done >= 1 and end.complete


def test_no_permission_and_no_store(store: str, files: Any, formula: Path) -> None:
    _, err = run_cluster(*job(formula, "s3://no-such-bucket/x"), code=2)
    assert err.startswith("agrik-fast: s3://no-such-bucket/x")
    assert len(err.strip().splitlines()) == 1
    _, err = run_cluster(*job(formula, "nowhere://x"), code=2)
    assert "nowhere://x: cannot be opened: Protocol not known: nowhere" in err
    _, err = run_cluster("status", f"{store}/nothing", code=2)
    assert "no such folder of results" in err
