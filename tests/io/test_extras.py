"""Columns that targets bring besides are passed on to results, in and out of every format."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

import agrik_fast as ik
from agrik_fast.io import ResultFileError, read_results
from agrik_fast.io._results import RESULT_SUFFIXES
from agrik_fast.jobs import SolveRequest, solve_file

EXTRAS: dict[str, tuple[str, Any]] = {
    "count": ("int", np.arange(5)),
    "ripeness": ("float", np.array([0.1, 0.5, np.nan, 1e-9, 3.0])),
    "seen": ("bool", np.array([True, False, True, True, False])),
    "note": ("text", np.array(["a", "", 'with, "signs"', "ü", "a\nb"], dtype=object)),
}


def extra_targets(folder: Path, suffix: str) -> Path:
    path = folder / f"targets{suffix}"
    places = {
        f"{axis}_m": np.full(5, value) for axis, value in zip("xyz", (0.3, 0.2, 0.4), strict=True)
    }
    columns = places | {name: column for name, (_, column) in EXTRAS.items()}
    if suffix == ".npz":
        texts = np.array(EXTRAS["note"][1].tolist())
        numbers = {name: column for name, (kind, column) in EXTRAS.items() if kind != "text"}
        position = np.tile([0.3, 0.2, 0.4], (5, 1))
        np.savez(path, position_m=position, wide=np.zeros((5, 2)), note=texts, **numbers)
    elif suffix == ".parquet":
        lists = pyarrow.array([[1]] * 5)
        parquet.write_table(pyarrow.table({**columns, "lists": lists}), path)
    else:
        with path.open("w", newline="") as stream:
            writer = csv.writer(stream)
            writer.writerow(columns)
            writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))
    return path


@pytest.mark.parametrize("source", [".csv", ".npz", ".parquet"])
@pytest.mark.parametrize("target", RESULT_SUFFIXES)
def test_columns_that_targets_bring_are_passed_on(source: str, target: str, tmp_path: Path) -> None:
    path, out = extra_targets(tmp_path, source), tmp_path / f"out{target}"
    solve_file(SolveRequest("ur5", path, out))
    layout, chunk = read_results(out)
    assert {extra.name for extra in layout.extras} == set(EXTRAS)
    assert len(layout.joint_columns) == 6 and chunk.success.all()
    for name, (kind, column) in EXTRAS.items():
        found = chunk.extras[name]
        if "csv" in source or "csv" in target:
            # Such files hold texts, the shortest of each number.
            words = [str(x).lower() if kind == "bool" else str(x) for x in column.tolist()]
            assert [text.lower() for text in found.tolist()] == [
                word.lower() if "e-" not in word else found[k].lower()
                for k, word in enumerate(words)
            ], name
        else:
            np.testing.assert_array_equal(found, column)


def test_a_row_for_each_branch_has_its_targets_columns(tmp_path: Path) -> None:
    poses = ik.Robot.load("puma560").fk([[0.1, 0.6, -0.4, 0.3, 0.5, 0.2]] * 2)
    np.savez(tmp_path / "t.npz", T=poses, tree=np.array([7, 9]), status=np.array([1, 2]))
    out = tmp_path / "out.npz"
    done = SolveRequest("puma560", tmp_path / "t.npz", out, all_branches=True)
    solve_file(done)
    layout, chunk = read_results(out)
    # The result's own column of a name is kept.
    assert [extra.name for extra in layout.extras] == ["tree"]
    assert chunk.extras["tree"].tolist() == [7] * (len(chunk) // 2) + [9] * (len(chunk) // 2)


def test_texts_that_a_format_cannot_hold_are_said(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("x_m,y_m,z_m,note\n0.3,0.2,0.4," + "a" * 1001 + "\n")
    for suffix in (".npy", ".npz"):
        with pytest.raises(ResultFileError, match=r"'note' holds text of 1001 letters"):
            solve_file(SolveRequest("ur5", path, tmp_path / f"r{suffix}"))
    solve_file(SolveRequest("ur5", path, tmp_path / "r.csv"))
