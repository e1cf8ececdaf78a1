"""Rows of a formula: grids and random rows, the same in any cut, and faults by name."""

from pathlib import Path

import numpy as np
import pytest

from agrik_fast.jobs import FormulaSource, JobError
from cluster_tools import write_formula

GRID = """\
rows_per_partition = 7
[[axis]]
column = "x_m"
from = 0.0
to = 1.0
count = 3
[[axis]]
columns = ["y_m", "z_m"]
values = [[1, 2], [3, 4], [5, 6], [7, 8]]
[[random]]
column = "s"
from = -1
to = 1
"""


def rows_of(source: FormulaSource, size: int = 1_000) -> np.ndarray:
    names = tuple(source.schema.names)
    batches = [
        batch
        for number in range(source.count)
        for batch in source.partition(number).data.batches(names, size)
    ]
    return np.vstack([np.stack([c.to_numpy() for c in batch.columns], axis=1) for batch in batches])


def test_a_grid_is_its_axes_product_the_last_turning_fastest(tmp_path: Path) -> None:
    (tmp_path / "g.toml").write_text(GRID)
    source = FormulaSource(tmp_path / "g.toml")
    assert (source.count, source.rows) == (2, 12)
    found = rows_of(source)
    assert found[:, 0].tolist() == [0.0] * 4 + [0.5] * 4 + [1.0] * 4
    assert found[:, 1].tolist() == [1, 3, 5, 7] * 3
    assert found[:, 2].tolist() == [2, 4, 6, 8] * 3
    assert (np.abs(found[:, 3]) < 1).all() and len(set(found[:, 3])) == 12
    assert [source.partition(k).first for k in range(2)] == [0, 7]
    assert source.partition(1).name == "part-000000001"


@pytest.mark.parametrize("size", [1, 17, 1_000])
def test_random_rows_do_not_depend_on_the_cut(tmp_path: Path, size: int) -> None:
    one = FormulaSource(write_formula(tmp_path / "a.toml", 1_000, 1_000))
    many = FormulaSource(write_formula(tmp_path / "b.toml", 1_000, 130))
    assert many.count == 8
    found = rows_of(one)
    assert np.array_equal(found, rows_of(many, size))
    quat = found[:, 3:]
    assert np.abs(np.linalg.norm(quat, axis=1) - 1).max() < 1e-15
    # Uniform rotations: every component has mean 0 and mean square 1/4.
    assert np.abs(quat.mean(axis=0)).max() < 0.06
    assert np.abs((quat**2).mean(axis=0) - 0.25).max() < 0.03


def test_sine_and_cosine_are_those_of_the_library() -> None:
    from agrik_fast.jobs import _formula

    u = np.linspace(0.0, 1.0, 10_001)
    sine, cosine = _formula._circle(u)
    assert np.abs(sine - np.sin(2 * np.pi * u)).max() < 1e-15
    assert np.abs(cosine - np.cos(2 * np.pi * u)).max() < 1e-15


def test_a_million_partitions_are_in_folders_and_cost_nothing(tmp_path: Path) -> None:
    source = FormulaSource(write_formula(tmp_path / "g.toml", 10**12, 10**6))
    assert source.count == 10**6
    partition = source.partition(123_456)
    assert partition.name == "p0123/part-000123456"
    assert partition.first == 123_456 * 10**6
    assert next(partition.data.batches(("x_m",), 10)).num_rows == 10


AXIS = '[[axis]]\ncolumn = "x_m"\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "neither [[axis]] nor [[random]]"),
        ("rows = 1 2", "not a TOML file"),
        ("row = 1", "unknown key 'row', expected one of rows, seed"),
        ("axis = 3", "'axis' holds 3, expected tables [[axis]]"),
        (AXIS, "[[axis]] 1: missing key 'count'"),
        (AXIS + "count = 1", "[[axis]] 1: 'count' holds 1, expected a whole number, 2 to"),
        (AXIS + "count = 3", "[[axis]] 1: missing key 'from'"),
        (AXIS + "count = 3\nfrom = 1\nto = 1", "'from' 1.0 and 'to' 1.0, expected the smaller"),
        (AXIS + "count = 3\nfrom = nan\nto = 1", "'from' holds nan, expected a finite number"),
        (AXIS + "count = 3\nfrom = 'a'\nto = 1", "'from' holds 'a', expected a number"),
        (AXIS + "values = []", "'values' holds [], expected a list of 1 to"),
        (AXIS + "values = [[1, 2]]", "'values': [1.0, 2.0], expected 1 numbers"),
        (AXIS + "step = 3", "[[axis]] 1: unknown key 'step'"),
        ("rows = 3\n" + AXIS + "values = [1]", "'rows' beside [[axis]]"),
        ("seed = 3\n" + AXIS + "values = [1]", "'seed' without [[random]]"),
        (2 * (AXIS + "values = [1]\n"), "column 'x_m' is made twice"),
        ("[[random]]\nrotation = true", "missing key 'rows'"),
        ("rows = 0\n[[random]]\nrotation = true", "'rows' holds 0, expected a whole number, 1"),
        ("rows = 1\n[[random]]\nrotation = false", "'rotation' holds False, expected true"),
        ("rows = 1\n[[random]]\nfrom = 0\nto = 1", "[[random]] 1: expected 'column' or 'columns'"),
        ("rows = true\n[[random]]\nrotation = true", "'rows' holds True"),
    ],
)
def test_faults_are_named(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "g.toml").write_text(text)
    with pytest.raises(JobError) as caught:
        FormulaSource(tmp_path / "g.toml")
    assert words in str(caught.value)
    assert str(caught.value).startswith(str(tmp_path / "g.toml"))


def test_a_grid_beyond_all_indices_is_refused(tmp_path: Path) -> None:
    text = "".join(
        f"[[axis]]\ncolumn = 'c{k}'\ncount = 10000000\nfrom = 0\nto = 1\n" for k in range(3)
    )
    (tmp_path / "g.toml").write_text(text)
    with pytest.raises(JobError, match="expected at most 2\\*\\*63 - 1"):
        FormulaSource(tmp_path / "g.toml")
    with pytest.raises(JobError, match="cannot be read: no such file"):
        FormulaSource(tmp_path / "none.toml")
