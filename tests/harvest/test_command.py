"""``agrik-fast harvest`` and the report that it writes."""

from __future__ import annotations

import csv
import json
from pathlib import Path

from agrik_fast import harvest
from cli_runner import run_command


def test_a_scene_of_ones_own(tmp_path: Path) -> None:
    scene = tmp_path / "scene.json"
    harvest.example_scene().save(scene)
    out = tmp_path / "out"
    done = run_command("harvest", str(scene), "-o", str(out))
    assert done.exit_code == 0, done.stderr
    names = {path.name for path in out.iterdir()}
    assert {"harvest.csv", "harvest.json", "shares.png", "row.png", "posture.png"} <= names
    assert "blockers.png" in names
    with (out / "harvest.csv").open() as file:
        rows = {row["target"]: row for row in csv.DictReader(file)}
    assert rows["C1"]["status"] == "OK"
    assert rows["C2"]["blockers"] == "leaf_e"
    assert rows["too_far"]["blockers"] == ""
    record = json.loads((out / "harvest.json").read_text())
    assert record["fruits"] == 6
    assert record["share_ok"] == 2 / 6
    assert sum(record["shares"].values()) == 1
    assert "6 of 6" in done.stderr or "6 fruits" in done.stderr
    again = run_command("harvest", str(scene), "-o", str(out))
    assert again.exit_code == 2
    assert "holds files" in again.stderr


def test_what_is_wrong_is_said(tmp_path: Path) -> None:
    empty = harvest.example_scene()
    scene = tmp_path / "scene.json"
    type(empty)(empty.objects).save(scene)
    done = run_command("harvest", str(scene), "-o", str(tmp_path / "out"))
    assert done.exit_code == 2
    assert "target for each fruit" in done.stderr
    assert "Traceback" not in done.stderr
    harvest.example_scene().save(tmp_path / "fruits.json")
    fruits = str(tmp_path / "fruits.json")
    done = run_command("harvest", fruits, "-o", str(tmp_path / "out"), "--robot", "panda")
    assert done.exit_code == 2
    assert "no slide" in done.stderr
    done = run_command("harvest", fruits, "-o", str(tmp_path / "out"), "--distance", "near")
    assert done.exit_code == 2
    assert "tree" in done.stderr
