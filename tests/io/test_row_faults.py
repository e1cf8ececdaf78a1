"""Faults of several rows: all are told, a line each, up to twenty."""

from pathlib import Path

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from agrik_fast.io import ResultFileError, TargetFileError, read_results, read_targets
from cli_runner import run_command

HEAD = "id,x_m,y_m,z_m\n"


def reason(path: Path) -> list[str]:
    with pytest.raises(TargetFileError) as caught:
        read_targets(path).read_all()
    return caught.value.reason.splitlines()


def csv(folder: Path, rows: list[str]) -> Path:
    path = folder / "t.csv"
    path.write_text(HEAD + "\n".join(rows) + "\n")
    return path


def test_all_rows_of_a_csv_file_are_told(tmp_path: Path) -> None:
    rows = ["a,1,2", "b,1,2,3", "c,1,two,3", "# none", "d,1,2,", f"{'e' * 1001},1,2,3"]
    assert reason(csv(tmp_path, rows)) == [
        "3 rows are faulty",
        "  row 1 (line 2): 3 fields, expected 4 as in the header",
        "  row 3 (line 4), column 'y_m': expected a number, got 'two'",
        "  row 4 (line 6), column 'z_m': expected a number, got ''",
    ]
    ids = ["a,1,2,3", *(f"{'e' * count},1,2,3" for count in (1001, 1000, 1002))]
    assert reason(csv(tmp_path, ids)) == [
        "2 rows are faulty",
        "  row 2 (line 3), column 'id': 1001 letters, expected at most 1000",
        "  row 4 (line 5), column 'id': 1002 letters, expected at most 1000",
    ]


def test_a_single_fault_has_no_heading(tmp_path: Path) -> None:
    expected = "row 2 (line 3): 2 fields, expected 4 as in the header"
    assert reason(csv(tmp_path, ["a,1,2,3", "b,1"])) == [expected]


def test_faults_are_counted_to_the_end_of_the_file(tmp_path: Path) -> None:
    # More rows than are read at a time.
    rows = ["a,1,2,3" if k % 10_000 else "a,1,2,oops" for k in range(300_000)]
    told = reason(csv(tmp_path, rows))
    assert told[0] == "30 rows are faulty" and told[-1] == "  and 10 more"
    assert len(told) == 22 and told[20].startswith("  row 190001 (line 190002), column 'z_m'")


def test_what_makes_reading_on_impossible_is_the_last_fault(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_bytes(HEAD.encode() + b"a,1,2\n\xff,1,2,3\n" + b'"' + b"a" * 1_200_000)
    assert reason(path) == [
        "3 rows are faulty",
        "  row 1 (line 2): 3 fields, expected 4 as in the header",
        "  line 3: is not UTF-8 text",
        "  line 4: a row of more than 1048576 letters",
    ]


def test_a_faulty_header_is_the_only_fault(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_bytes(b"id,\xff,y_m,z_m\na,1,2\n")
    assert reason(path) == ["line 1: is not UTF-8 text"]


def test_the_command_tells_them_a_line_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    csv(tmp_path, ["a,1,2"] * 23)
    result = run_command("solve", "ur5", "t.csv", "-o", "r.csv")
    head, *lines = result.stderr.splitlines()
    assert result.exit_code == 2 and head == "agrik-fast: t.csv: 23 rows are faulty"
    assert lines[0] == "  row 1 (line 2): 3 fields, expected 4 as in the header"
    assert len(lines) == 21 and lines[-1] == "  and 3 more"
    assert not Path("r.csv").exists()


def test_all_rows_of_a_parquet_file_are_told(tmp_path: Path) -> None:
    count = 100_000
    x = np.zeros(count, dtype=np.int64)
    x[[4, 99_998]] = 2**53 + 1
    ids = [f"a{k}" for k in range(count)]
    ids[70_000] = "e" * 1001
    for dictionary in (False, True):
        column = pyarrow.array([None, *ids[1:]])
        table = pyarrow.table(
            {
                "x_m": x,
                "y_m": np.zeros(count),
                "z_m": np.zeros(count),
                "id": column.dictionary_encode() if dictionary else column,
            }
        )
        parquet.write_table(table, tmp_path / "t.parquet")
        assert reason(tmp_path / "t.parquet") == [
            "4 rows are faulty",
            "  row 1, column 'id': is empty",
            f"  row 5, column 'x_m': expected a number that float64 holds, at most 2**53, "
            f"got {2**53 + 1}",
            "  row 70001, column 'id': 1001 letters, expected at most 1000",
            f"  row 99999, column 'x_m': expected a number that float64 holds, at most 2**53, "
            f"got {2**53 + 1}",
        ]


def test_all_ids_of_an_archive_are_told(tmp_path: Path) -> None:
    path = tmp_path / "t.npz"
    ids = np.array([2**63, 1, 2**63 + 5], dtype=np.uint64)
    np.savez(path, position_m=np.zeros((3, 3)), id=ids)
    assert reason(path) == [
        "2 rows are faulty",
        "  row 1, 'id': is beyond 2**63 - 1",
        "  row 3, 'id': is beyond 2**63 - 1",
    ]


def test_all_rows_of_results_are_told(tmp_path: Path) -> None:
    np.save(tmp_path / "t.npy", np.full((3, 3), 0.4))
    path = tmp_path / "r.csv"
    assert run_command("solve", "ur5", tmp_path / "t.npy", "-o", path).exit_code == 0
    path.write_text(path.read_text().replace("converged", "done"))
    with pytest.raises(ResultFileError, match="3 rows are faulty\n  line 2, 'status': expected"):
        read_results(path)
