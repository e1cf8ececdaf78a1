"""Result files: every kind reads back, and the file appears only when it is complete."""

from pathlib import Path

import numpy as np
import pytest

from agrik_fast import Status
from agrik_fast.io import (
    ResultChunk,
    ResultFileError,
    ResultLayout,
    SceneColumns,
    open_results,
    read_results,
)
from agrik_fast.io._results import RESULT_SUFFIXES

LAYOUT = ResultLayout(("s10_m", "theta_rad"), metadata={"robot": "toy", "seed": "7"})


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def results(
    count: int, first: int = 1, text_ids: bool = False, in_scene: bool = False
) -> ResultChunk:
    random = np.random.default_rng(first)
    ids = np.arange(first, first + count)
    status = (np.arange(count) % len(Status)).astype(np.int8)
    return ResultChunk(
        ids=np.array([f"row {k}" for k in ids]) if text_ids else ids,
        q=np.where(status[:, None] == 3, np.nan, random.normal(size=(count, 2))),
        status=status,
        success=status == 0,
        position_error=random.random(count) * 1e-7,
        orientation_error=np.full(count, np.nan),
        iterations=random.integers(0, 99, count).astype(np.int32),
        restarts=random.integers(0, 9, count).astype(np.int32),
        scene=meetings(count, first) if in_scene else None,
    )


def meetings(count: int, first: int) -> SceneColumns:
    gaps = np.random.default_rng(first).normal(size=count)
    gaps[::3] = np.inf
    bodies = np.array(["", "hand", "forearm"])[np.arange(count) % 3]
    return SceneColumns(gaps, bodies, np.array(["", "leaf, left", "ä"])[np.arange(count) % 3])


def assert_same(one: ResultChunk, other: ResultChunk) -> None:
    for name in ResultChunk.__dataclass_fields__:
        if name != "scene":
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
    assert (one.scene is None) == (other.scene is None)
    if one.scene is not None and other.scene is not None:
        for name in SceneColumns.__dataclass_fields__:
            pair = getattr(one.scene, name), getattr(other.scene, name)
            np.testing.assert_array_equal(*pair, err_msg=name)


@pytest.mark.parametrize("in_scene", [False, True])
@pytest.mark.parametrize("text_ids", [False, True])
@pytest.mark.parametrize("suffix", RESULT_SUFFIXES)
def test_results_read_back_to_the_same_bits(
    tmp_path: Path, suffix: str, text_ids: bool, in_scene: bool
) -> None:
    path = tmp_path / f"results{suffix}"
    letters = 10 if in_scene else 0
    layout = ResultLayout(LAYOUT.joint_columns, text_ids, LAYOUT.metadata, letters)
    sizes = ((7, 1), (5, 8), (120, 13))
    parts = [results(count, first, text_ids, in_scene) for count, first in sizes]
    with open_results(path, layout) as writer:
        for part in parts:
            writer.write(part)
        assert not path.exists()
    back_layout, back = read_results(path)
    whole = ResultChunk.joined(parts)
    if suffix == ".csv" and not text_ids:
        back = ResultChunk(**{**vars(back), "ids": back.ids.astype(int)})
    assert_same(back, whole)
    assert back_layout.joint_columns == LAYOUT.joint_columns
    if suffix in (".npz", ".parquet"):
        assert back_layout.metadata == LAYOUT.metadata
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_csv_results_look_as_documented(tmp_path: Path) -> None:
    with open_results(tmp_path / "r.csv", LAYOUT) as writer:
        writer.write(
            ResultChunk(
                ids=np.array([1]),
                q=np.array([[0.1, -1.5]]),
                status=np.array([0]),
                success=np.array([True]),
                position_error=np.array([2e-9]),
                orientation_error=np.array([0.0]),
                iterations=np.array([5]),
                restarts=np.array([0]),
            )
        )
    assert (tmp_path / "r.csv").read_text() == (
        "id,s10_m,theta_rad,status,success,position_error_m,orientation_error_rad,"
        "iterations,restarts\n1,0.1,-1.5,converged,true,2e-9,0.0,5,0\n"
    )


def test_joint_columns_carry_units() -> None:
    names = ResultLayout.joint_names(
        ["s10", "theta", "roll"], ["prismatic", "revolute", "continuous"]
    )
    assert names == ("s10_m", "theta_rad", "roll_rad")


@pytest.mark.parametrize("suffix", RESULT_SUFFIXES)
def test_an_error_leaves_the_old_file_untouched(tmp_path: Path, suffix: str) -> None:
    path = write(tmp_path / f"r{suffix}", "old")
    writer = open_results(path, LAYOUT, force=True)

    def interrupted_job() -> None:
        with writer:
            writer.write(results(10))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted_job()
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_an_existing_result_needs_force(tmp_path: Path) -> None:
    path = write(tmp_path / "r.csv", "old")
    with pytest.raises(ResultFileError, match=r"exists already \(use --force to replace it\)"):
        open_results(path, LAYOUT)
    with open_results(path, LAYOUT, force=True) as writer:
        writer.write(results(3))
    assert len(path.read_text().splitlines()) == 4


def test_a_file_made_meanwhile_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    writer = open_results(path, LAYOUT)
    writer.write(results(3))
    write(path, "somebody else's")
    with pytest.raises(ResultFileError, match="exists already"):
        writer.close()
    assert path.read_text() == "somebody else's"
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_results_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(ResultFileError, match="cannot be written: no such file or directory"):
        open_results(tmp_path / "nowhere" / "r.csv", LAYOUT)
    write(tmp_path / "file", "")
    with pytest.raises(ResultFileError, match="cannot be written: not a directory"):
        open_results(tmp_path / "file" / "r.csv", LAYOUT)
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(ResultFileError, match="is a folder, expected a file name"):
        open_results(tmp_path / "folder.npz", LAYOUT)
    with pytest.raises(ResultFileError, match=r"unknown suffix '.txt', expected one of .csv"):
        open_results(tmp_path / "r.txt", LAYOUT)
    with pytest.raises(ResultFileError, match="cannot be read"):
        read_results(tmp_path / "absent.csv")
    with pytest.raises(ResultFileError, match="is not a result file"):
        read_results(write(tmp_path / "other.csv", "a,b\n1,2\n"))


def test_a_link_is_followed(tmp_path: Path) -> None:
    real = write(tmp_path / "real.csv", "old")
    link = tmp_path / "link.csv"
    link.symlink_to(real)
    with open_results(link, LAYOUT, force=True) as writer:
        writer.write(results(2))
    assert link.is_symlink()
    assert len(real.read_text().splitlines()) == 3
