"""Whatever is killed, full, cut off or changed: the same bytes after the next start, no orphans."""

import json
import os
import resource
import shutil
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from cluster_tools import (
    ROBOT,
    Processes,
    ended,
    hashes,
    processes,
    run_cluster,
    temporaries,
    wait_for,
    write_formula,
)

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are found in /proc")

PARTITIONS = 6


@pytest.fixture
def run() -> Iterator[Processes]:
    with processes() as started:
        yield started


@pytest.fixture(scope="module")
def formula(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_formula(tmp_path_factory.mktemp("formula") / "grid.toml")


@pytest.fixture(scope="module")
def whole(formula: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the results of a run that nothing disturbs."""
    folder = tmp_path_factory.mktemp("undisturbed") / "out"
    again(formula, folder)
    return folder


@pytest.fixture(scope="module")
def undisturbed(whole: Path) -> dict[str, str]:
    found = hashes(whole)
    assert len(found) == PARTITIONS + 1
    return found


def job(formula: Path, folder: Path, *more: object, workers: int = 2) -> tuple[object, ...]:
    options = ("--generate", formula, "--robot", ROBOT, "--workers", workers)
    return ("solve", folder, *options, *more)


def again(formula: Path, folder: Path, *more: object) -> tuple[str, str]:
    """Do the job to its end in this process."""
    return run_cluster(*job(formula, folder, *more, workers=1))


def parts(folder: Path) -> int:
    return len([path for path in folder.glob("*.json") if not path.name.startswith("_")])


def at_work(folder: Path) -> bool:
    """Return whether a part is being written."""
    return any(name.startswith(".part-") for name in temporaries(folder))


def test_a_killed_worker_is_replaced(
    run: Processes, formula: Path, undisturbed: dict[str, str], tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    driver = run.cluster(*job(formula, folder, "--log", tmp_path / "log"))
    wait_for(lambda: len(run.workers()) == 2 and at_work(folder))
    first, _ = run.workers()
    os.kill(first, signal.SIGKILL)
    out, err = ended(driver, 0)
    assert f"{PARTITIONS} partitions: {PARTITIONS} done" in out
    assert "retry: worker process ended (signal 9)" in err
    assert hashes(folder) == undisturbed
    assert temporaries(folder) == []
    assert run.gone() == {}
    events = [json.loads(line) for line in (tmp_path / "log").read_text().splitlines()]
    assert [e["event"] for e in events if e["event"] not in ("tick", "done")] == [
        "start", "retry", "end"
    ]  # fmt: skip
    assert events[-1]["rows_done"] == 1_800


@pytest.mark.parametrize("moment", [0, 2])
def test_a_killed_driver_leaves_no_orphans_and_half_a_job(
    run: Processes, formula: Path, undisturbed: dict[str, str], tmp_path: Path, moment: int
) -> None:
    folder = tmp_path / "out"
    driver = run.cluster(*job(formula, folder))
    wait_for(lambda: folder.exists() and parts(folder) >= moment)
    wait_for(lambda: at_work(folder))
    driver.kill()
    driver.communicate()
    assert run.gone() == {}
    there = parts(folder)
    assert there < PARTITIONS and not (folder / "_manifest.json").exists()
    out, _ = run_cluster("status", folder, code=4)
    assert out.startswith(f"{there} of {PARTITIONS} partitions") and out.endswith("not complete\n")
    out, _ = again(formula, folder)
    assert f"{PARTITIONS - there} done, {there} were there" in out
    assert hashes(folder) == undisturbed
    # What is left over is named so that nobody reads it, and goes when it is told to.
    left = len(temporaries(folder))
    out, _ = run_cluster("clean", folder)
    assert "0 temporary files removed" in out
    out, _ = run_cluster("clean", folder, "--older", 0)
    assert f"{left} temporary file" in out and temporaries(folder) == []
    assert hashes(folder) == undisturbed


@pytest.mark.parametrize(
    ("number", "code", "word"),
    [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated")],
)
def test_ctrl_c_ends_within_a_second_and_says_how_to_go_on(
    run: Processes,
    formula: Path,
    undisturbed: dict[str, str],
    tmp_path: Path,
    number: signal.Signals,
    code: int,
    word: str,
) -> None:
    folder = tmp_path / "out"
    driver = run.cluster(*job(formula, folder))
    wait_for(lambda: folder.exists() and parts(folder) >= 2 and at_work(folder))
    driver.send_signal(number)
    _, err = ended(driver, code)
    assert temporaries(folder) == []
    assert run.gone(1.0) == {}
    there = parts(folder)
    assert 0 < there < PARTITIONS
    last = err.splitlines()[-1]
    assert last.startswith(f"agrik-fast: {word}, ")
    assert f"of {PARTITIONS} partitions are there; go on with: agrik-fast cluster solve" in last
    assert str(formula) in last
    again(formula, folder)
    assert hashes(folder) == undisturbed


def test_a_second_ctrl_c_ends_at_once(run: Processes, formula: Path, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    driver = run.cluster(*job(formula, folder))
    wait_for(lambda: folder.exists() and at_work(folder))
    for worker in run.workers():
        os.kill(worker, signal.SIGSTOP)  # these do not answer
    driver.send_signal(signal.SIGINT)
    time.sleep(0.2)
    driver.send_signal(signal.SIGINT)
    ended(driver, 130)
    assert run.gone() == {}


def test_a_full_disk_is_a_list_of_failures(
    run: Processes, formula: Path, whole: Path, undisturbed: dict[str, str], tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    size = min(path.stat().st_size for path in whole.glob("*.parquet"))

    def small() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (size // 2, size // 2))

    driver = run.cluster(*job(formula, folder, "--retries", 1), set_up=small)
    _, err = ended(driver, 4)
    assert f"{PARTITIONS} of {PARTITIONS} partitions failed" in err
    assert "cannot be written: file too large" in err
    assert temporaries(folder) == [] and hashes(folder) == {}
    failed = json.loads((folder / "_failed.json").read_text())
    assert [each["first"] for each in failed] == [300 * k for k in range(PARTITIONS)]
    assert {each["attempts"] for each in failed} == {2}
    out, _ = run_cluster("status", folder, code=4)
    assert out.count("failed: part-") == PARTITIONS
    again(formula, folder)
    assert hashes(folder) == undisturbed
    assert not (folder / "_failed.json").exists()


@pytest.mark.skipif(os.geteuid() != 0, reason="only root mounts file systems")
def test_a_small_file_system_fills_up(
    run: Processes, formula: Path, undisturbed: dict[str, str], tmp_path: Path
) -> None:
    folder = tmp_path / "small"
    folder.mkdir()
    if os.system(f"mount -t tmpfs -o size=80k none {folder}"):
        pytest.skip("this system mounts nothing")
    try:
        out, err = ended(run.cluster(*job(formula, folder / "out", "--retries", 0)), 4)
        assert "no space left on device" in err
        there = parts(folder / "out")
        assert f"{there} done" in out and 0 < there < PARTITIONS
        os.system(f"mount -o remount,size=10m {folder}")
        out, _ = again(formula, folder / "out")
        assert f"{there} were there" in out
        assert hashes(folder / "out") == undisturbed
    finally:
        os.system(f"umount {folder}")


@pytest.fixture
def finished(whole: Path, tmp_path: Path) -> Path:
    """Return a copy of results that are all there."""
    return Path(shutil.copytree(whole, tmp_path / "out"))


def test_truncated_and_missing_results_are_made_anew(
    formula: Path, finished: Path, undisturbed: dict[str, str]
) -> None:
    files = sorted(finished.glob("*.parquet"))
    os.truncate(files[1], files[1].stat().st_size - 100)
    files[2].unlink()
    files[3].with_name(files[3].name + ".json").unlink()
    files[4].with_name(files[4].name + ".json").write_text("{")
    out, _ = run_cluster("verify", finished, "--keep", code=4)
    assert f"{files[1].name}: has" in out and f"{files[2].name}: is missing" in out
    assert f"{files[4].name}.json: the record is damaged" in out
    out, _ = again(formula, finished)
    assert "4 done, 2 were there" in out
    assert hashes(finished) == undisturbed


def test_a_flipped_bit_is_found_and_mended(
    formula: Path, finished: Path, undisturbed: dict[str, str]
) -> None:
    out, _ = run_cluster("verify", finished)
    assert f"{PARTITIONS} parts" in out and "0 damaged" in out
    victim = sorted(finished.glob("*.parquet"))[5]
    data = bytearray(victim.read_bytes())
    data[len(data) // 2] ^= 1
    victim.write_bytes(data)
    # The size is the same: nothing but reading tells.
    out, _ = again(formula, finished)
    assert f"{PARTITIONS} were there" in out
    out, _ = run_cluster("verify", finished, code=4)
    assert f"{victim.name}: is not what was written" in out and "1 damaged" in out
    assert not (finished / "_manifest.json").exists()
    out, _ = again(formula, finished)
    assert f"1 done, {PARTITIONS - 1} were there" in out
    assert hashes(finished) == undisturbed
    run_cluster("verify", finished)


def test_a_changed_job_is_refused_then_done_as_if_alone(
    formula: Path, finished: Path, undisturbed: dict[str, str], tmp_path: Path
) -> None:
    _, err = run_cluster(*job(formula, finished, "--seed", 5), code=2)
    assert "holds results of another job: seed 0, not 5" in err
    assert hashes(finished) == undisturbed
    again(formula, tmp_path / "alone", "--seed", 5)
    again(formula, finished, "--seed", 5, "--force")
    assert hashes(finished) == hashes(tmp_path / "alone") != undisturbed


def test_shards_make_the_same_folder(
    run: Processes, formula: Path, undisturbed: dict[str, str], tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    started = [run.cluster(*job(formula, folder, "--shard", f"{k}/3")) for k in range(3)]
    told = [ended(each, 0)[0] for each in started]
    assert hashes(folder) == undisturbed
    assert sorted(out.split()[0] for out in told) == ["2", "2", "2"]
    assert sum("other shards are not done yet" in out for out in told) <= 2
