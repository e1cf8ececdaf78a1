"""Harvest evaluation of many crops as a job: the same rows however they are cut."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pyarrow
import pytest
from pyarrow import parquet

from agrik_fast import ArgumentError, cluster, harvest
from agrik_fast.collision import greenhouse
from agrik_fast.harvest import CropsJob, Settings
from agrik_fast.jobs import Assignment, FileSource, JobError, open_store, run_partition
from cluster_tools import hashes, run_cluster, write_parts

COLUMNS = {
    "id": [11, 12, 13, 14, 15, 16, 17, 18],
    "seed": [1, 2, 3, 4, 5, 6, 7, 8],
    "plants": [2] * 8,
    "leaves": [0, 4, 8, 12] * 2,
    "stem_x_m": [0.735, 0.735, 0.735, 0.735, 0.7, 0.7, 0.7, 5.0],
    "clear_from_m": [0.65] * 8,
    "clear_to_m": [1.3] * 8,
}
TABLE = pyarrow.table(COLUMNS)


def rows(folder: Path) -> list[dict[str, Any]]:
    parts = sorted(path for path in folder.glob("*.parquet") if not path.name.startswith("."))
    return pyarrow.concat_tables([parquet.read_table(part) for part in parts]).to_pylist()


@pytest.mark.parametrize("pieces", [1, 3])
def test_a_row_a_crop_as_evaluate_has_it(pieces: int, tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    for k in range(pieces):
        first, last = 8 * k // pieces, 8 * (k + 1) // pieces
        parquet.write_table(TABLE.slice(first, last - first), tmp_path / "in" / f"{k}.parquet")
    source, store = FileSource(tmp_path / "in"), open_store(tmp_path / "out")
    assignment = Assignment(job := CropsJob("cucumber"), source.check(job))
    store.prepare()
    for k in range(source.count):
        run_partition(assignment, source.partition(k), store)
    found = rows(tmp_path / "out")
    assert [row["id"] for row in found] == COLUMNS["id"]
    assert [row["fruits"] for row in found] == [2] * 8
    for k in (0, 3, 6):
        scene = greenhouse(
            COLUMNS["seed"][k],  # type: ignore[arg-type]
            2,
            COLUMNS["leaves"][k],  # type: ignore[arg-type]
            stem_x=COLUMNS["stem_x_m"][k],
            clear_band=(0.65, 1.3),
        )
        direct = harvest.evaluate(scene, "cucumber")
        assert found[k]["share_ok"] == direct.share
        assert found[k]["ok"] == int(direct.decisions.ok.sum())
        assert found[k]["error"] == ""
    assert found[7]["out_of_reach"] == 2 and found[7]["share_ok"] == 0.0
    assert len({row["share_ok"] for row in found}) > 1


def test_scene_files_and_what_is_no_scene(tmp_path: Path) -> None:
    greenhouse(seed=1, plants=2, leaves=8).save(tmp_path / "one.json")
    (tmp_path / "bad.json").write_text("{}")
    paths = [str(tmp_path / name) for name in ("one.json", "bad.json", "none.json")]
    parquet.write_table(pyarrow.table({"scene": paths}), tmp_path / "crops.parquet")
    out, _ = run_cluster("harvest", tmp_path / "crops.parquet", tmp_path / "out", "--workers", 1)
    assert "3 rows: 2 bad_crop, 1 evaluated" in out
    good, bad, none = rows(tmp_path / "out")
    assert good["fruits"] == 2 and good["error"] == ""
    assert "unit: missing" in bad["error"] and "which is no file" in none["error"]
    words = ("harvest", tmp_path / "crops.parquet", tmp_path / "out", "--workers", 1, "--strict")
    run_cluster(*words, code=3)


def test_command_and_call_leave_the_same_bytes(tmp_path: Path) -> None:
    source = write_parts(tmp_path / "in", TABLE, 2)
    options = ("--workers", 2, "--no-blockers", "--min-distance", 0.01, "--no-refine")
    run_cluster("harvest", source, tmp_path / "command", *options)
    job = CropsJob("cucumber", Settings(min_distance=0.01, refine=False), blockers=False)
    end = cluster.harvest(source, tmp_path / "call", job, workers=1)
    assert end.complete and end.counts == {"evaluated": 8}
    assert hashes(tmp_path / "command") == hashes(tmp_path / "call")
    again = cluster.harvest(source, tmp_path / "call", job, workers=1)
    assert again.skipped == again.partitions


def test_what_cannot_be_evaluated_is_said_before_anything_starts(tmp_path: Path) -> None:
    def refused(columns: dict[str, Any], *options: object) -> str:
        parquet.write_table(pyarrow.table(columns), tmp_path / "in.parquet")
        words = ("harvest", tmp_path / "in.parquet", tmp_path / "out", *options)
        _, err = run_cluster(*words, code=2)
        assert not (tmp_path / "out").exists()
        return err

    assert "no column that says what the crops are" in refused({"x_m": [1.0]})
    assert "expected one way to say the crop" in refused({"scene": ["a"], "seed": [1]})
    assert "expected both or none" in refused({"clear_to_m": [1.0]})
    assert "expected paths" in refused({"scene": [1]})
    assert "no slide" in refused({"seed": [1]}, "--robot", "panda")
    with pytest.raises(ArgumentError, match="time limit"):
        CropsJob("cucumber", Settings(time_limit=1.0))
    with pytest.raises(ArgumentError, match="CropsJob"):
        cluster.harvest(None, tmp_path / "out", generate=tmp_path / "none.toml")
    parquet.write_table(pyarrow.table({"scene": [1.0]}), tmp_path / "in.parquet")
    with pytest.raises(JobError, match="holds double"):
        FileSource(tmp_path / "in.parquet").check(CropsJob("cucumber"))
