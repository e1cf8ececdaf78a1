"""More targets than memory holds: files of any length, and `Robot.ik_stream`."""

import gc
import itertools
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from numpy.lib.format import open_memmap
from pyarrow import parquet

import agrik_fast as ik
from agrik_fast._background import Started, ahead
from agrik_fast.io import read_results
from agrik_fast.jobs._spread import Spread

FIELDS = ("q", "success", "status", "position_error", "iterations", "restarts")

# The peak of a process never falls, so each measurement has one of its own. Linux counts the
# high-water mark anew for a new program, which getrusage does not.
SOLVE = """
import sys
from pathlib import Path
from agrik_fast.jobs import SolveRequest, solve_file

robot, targets, output = sys.argv[1:]
summary = solve_file(SolveRequest(robot, Path(targets), Path(output)))
assert summary.solved == summary.rows, summary
status = Path("/proc/self/status")
if status.exists():
    (line,) = (line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
    print(int(line.split()[1]) * 1024)
else:
    import resource
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def write_points(path: Path, rows: int) -> None:
    """Write reachable points of the Puma: 4,000 of them, again and again."""
    arm = ik.Robot.load("puma560")
    few = arm.fk(arm.random_q(4_000, seed=4))[:, :3, 3]
    points = np.tile(few, (rows // len(few), 1))
    if path.suffix == ".npy":
        np.save(path, points)
        return
    columns = {name: np.ascontiguousarray(points[:, k]) for k, name in enumerate(("x", "y", "z"))}
    table = pyarrow.table({f"{name}_m": column for name, column in columns.items()})
    # The hardest case for a reader: the whole file is one row group of numbers as they are.
    parquet.write_table(table, path, row_group_size=rows, use_dictionary=False, compression="none")


def peak_bytes(targets: Path, output: Path) -> int:
    done = subprocess.run(
        [sys.executable, "-c", SOLVE, "puma560", str(targets), str(output)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return int(done.stdout)


@pytest.mark.parametrize("suffix", [".npy", ".parquet"])
def test_memory_does_not_grow_with_the_file(tmp_path: Path, suffix: str) -> None:
    sizes = []
    peaks = []
    for rows in (300_000, 1_500_000):
        targets, output = tmp_path / f"{rows}{suffix}", tmp_path / f"out{rows}{suffix}"
        write_points(targets, rows)
        peaks.append(peak_bytes(targets, output))
        sizes.append(targets.stat().st_size + output.stat().st_size)
    assert max(peaks) < 500e6
    assert sizes[1] - sizes[0] > 70e6
    # What allocators keep differs by some 30 MB from run to run.
    assert peaks[1] - peaks[0] < 45e6


def test_a_long_file_gets_the_answers_of_one_call(tmp_path: Path) -> None:
    write_points(tmp_path / "t.npy", 300_000)
    peak_bytes(tmp_path / "t.npy", tmp_path / "r.npy")
    _, rows = read_results(tmp_path / "r.npy")
    whole = ik.Robot.load("puma560").ik(np.load(tmp_path / "t.npy"))
    np.testing.assert_array_equal(rows.ids, np.arange(1, 300_001))
    for field in FIELDS:
        np.testing.assert_array_equal(getattr(rows, field), getattr(whole, field))


# ---- Robot.ik_stream ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def arm() -> ik.Robot:
    return ik.Robot.load("puma560")


@pytest.fixture(scope="module")
def targets(arm: ik.Robot) -> np.ndarray:
    return arm.fk(arm.random_q(3_000, seed=8))


def joined(results: list[ik.IkResult], field: str) -> np.ndarray:
    return np.concatenate([getattr(result, field) for result in results])


@pytest.mark.parametrize("task", ["pose", "position"])
def test_a_stream_gets_the_answers_of_one_call(
    arm: ik.Robot, targets: np.ndarray, task: str
) -> None:
    options = {"task": task, "seed": 3, "q0": np.zeros(6), "solver": "dls", "first_index": 7}
    whole = arm.ik(targets, **options)
    chunks = np.split(targets, [1, 2, 900, 901, 2_500])
    results = list(arm.ik_stream(iter(chunks), **options))
    assert [len(result.q) for result in results] == [1, 1, 898, 1, 1_599, 500]
    for field in FIELDS:
        assert joined(results, field).tobytes() == getattr(whole, field).tobytes()
    assert whole.success.mean() > 0.97


def test_chunks_of_other_shapes_count_all_their_targets(arm: ik.Robot, targets: np.ndarray) -> None:
    whole = arm.ik(targets[:14])
    chunks = [targets[0], targets[1:13].reshape(3, 4, 4, 4), targets[:0], targets[13].tolist()]
    results = list(arm.ik_stream(chunks))
    assert [result.status.shape for result in results] == [(), (3, 4), (0,), ()]
    q = np.concatenate([result.q.reshape(-1, 6) for result in results])
    np.testing.assert_array_equal(q, whole.q)


def test_indices_wrap_around_at_the_end_of_their_range(arm: ik.Robot, targets: np.ndarray) -> None:
    chunks = [targets[:2], targets[2:4], targets[4:6]]
    results = list(arm.ik_stream(chunks, first_index=2**64 - 3))
    whole = arm.ik(targets[:6], first_index=2**64 - 3)
    np.testing.assert_array_equal(joined(results, "q"), whole.q)


def test_one_chunk_is_solved_ahead_and_no_more(arm: ik.Robot, targets: np.ndarray) -> None:
    taken = []

    def chunks() -> Iterator[np.ndarray]:
        for k in range(6):
            taken.append(threading.current_thread())
            yield targets[100 * k : 100 * (k + 1)]

    stream = arm.ik_stream(chunks())
    assert not taken
    for k, result in enumerate(stream):
        assert result.success.all()
        assert len(taken) == min(k + 2, 6)
    assert set(taken) == {threading.main_thread()}
    assert list(arm.ik_stream([])) == []


def test_a_buffer_may_be_filled_again(arm: ik.Robot, targets: np.ndarray) -> None:
    def chunks() -> Iterator[np.ndarray]:
        buffer = np.empty((500, 4, 4))
        for first in range(0, 3_000, 500):
            buffer[:] = targets[first : first + 500]
            yield buffer
            buffer[:] = np.nan

    results = list(arm.ik_stream(chunks()))
    np.testing.assert_array_equal(joined(results, "q"), arm.ik(targets).q)


def test_a_map_of_a_file_is_a_stream(arm: ik.Robot, targets: np.ndarray, tmp_path: Path) -> None:
    # As docs/performance.md shows it.
    np.save(tmp_path / "targets.npy", targets)
    stored = np.load(tmp_path / "targets.npy", mmap_mode="r")
    chunks = (stored[k : k + 1_000] for k in range(0, len(stored), 1_000))
    out = open_memmap(tmp_path / "q.npy", "w+", np.float64, (len(stored), arm.dof))
    at = 0
    for result in arm.ik_stream(chunks):
        out[at : at + len(result.q)] = result.q
        at += len(result.q)
    out.flush()
    del out
    gc.collect()
    np.testing.assert_array_equal(np.load(tmp_path / "q.npy"), arm.ik(targets).q)


def test_faults_come_with_their_chunk(arm: ik.Robot, targets: np.ndarray) -> None:
    stream = arm.ik_stream([targets[:5], np.zeros((2, 5)), targets[5:9]])
    assert next(stream).success.all()
    with pytest.raises(ik.ArgumentError, match=r"`targets`: expected .* got .*\(2, 5\)"):
        next(stream)
    assert list(stream) == []
    with pytest.raises(ik.UnknownNameError, match="unknown solver 'lmm'"):
        next(arm.ik_stream([targets[:5]], solver="lmm"))
    with pytest.raises(ik.ArgumentError, match=r"`first_index`: expected a whole number"):
        arm.ik_stream([targets[:5]], first_index=-1)


def test_a_fault_of_the_chunks_is_the_callers(arm: ik.Robot, targets: np.ndarray) -> None:
    def chunks() -> Iterator[np.ndarray]:
        yield targets[:5]
        raise OSError("no more tape")

    with pytest.raises(OSError, match="no more tape"):
        list(arm.ik_stream(chunks()))


# ---- what they are made of ---------------------------------------------------------------------


def test_stages_overlap_within_their_depth() -> None:
    made = []

    def numbers() -> Iterator[int]:
        for k in itertools.count():
            made.append(k)
            yield k

    stage = ahead(numbers(), 2, "numbers")
    assert not made
    assert [next(stage) for _ in range(3)] == [0, 1, 2]
    deadline = time.monotonic() + 10
    while len(made) < 6 and time.monotonic() < deadline:
        time.sleep(0.01)
    time.sleep(0.1)
    # Three handed out, two waiting, one in hand.
    assert made == [0, 1, 2, 3, 4, 5]
    stage.close()


def test_closing_the_last_stage_ends_all() -> None:
    ended = threading.Event()

    def numbers() -> Iterator[int]:
        try:
            yield from itertools.count()
        finally:
            ended.set()

    def squares(stage: Iterator[int]) -> Iterator[int]:
        try:
            for k in stage:
                yield k * k
        finally:
            stage.close()

    last = ahead(squares(ahead(numbers(), 2, "numbers")), 2, "squares")
    assert [next(last) for _ in range(4)] == [0, 1, 4, 9]
    last.close()
    assert ended.wait(10)


def test_an_error_in_a_stage_reaches_the_caller_after_what_came_before() -> None:
    def numbers() -> Iterator[int]:
        yield 1
        raise ArithmeticError("two")

    stage = ahead(ahead(numbers(), 1, "inner"), 1, "outer")
    assert next(stage) == 1
    with pytest.raises(ArithmeticError, match="two"):
        next(stage)
    with pytest.raises(ZeroDivisionError):
        Started(lambda: 1 // 0, "division").result()
    assert Started(lambda: 41 + 1, "sum").result() == 42


@pytest.mark.parametrize("count", [1, 2, 3, 10, 1_001, 20_000])
def test_the_median_is_right_to_one_percent(count: int) -> None:
    generator = np.random.default_rng(count)
    errors = 10.0 ** generator.uniform(-18, -6, count)
    errors[::7] = 0.0
    spread = Spread()
    for part in np.array_split(errors, 7):
        spread.add(part)
    assert spread.median() == pytest.approx(np.median(errors), rel=0.01)
    assert spread.largest() == errors.max()


def test_spreads_of_odd_errors() -> None:
    empty = Spread()
    assert np.isnan([empty.median(), empty.largest()]).all()
    zeros = Spread()
    zeros.add(np.zeros(3))
    assert (zeros.median(), zeros.largest()) == (0.0, 0.0)
    extreme = Spread()
    extreme.add(np.array([5e-324, 1e-30, 1e9]))
    assert 5e-324 <= extreme.median() <= 1e-22
    assert extreme.largest() == 1e9
    same = Spread()
    same.add(np.full(5, 3e-7))
    assert same.median() == 3e-7
