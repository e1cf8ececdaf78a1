"""What a search keeps: nothing is lost, and nothing is taken up that no run wrote."""

import dataclasses
import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast.errors import GainFileError
from agrik_fast.solvers import gain_file
from agrik_fast.tuning import Report, Tuning, tune
from agrik_fast.tuning import _checkpoint as checkpoint_module
from agrik_fast.tuning import _plan as plan_module
from agrik_fast.tuning import _search as search_module
from agrik_fast.tuning._checkpoint import Progress

ARM = ik.Robot.load("hydrolek")
QUICK = Tuning(goals=20, evaluations=80, runs=2, refinement=0)


class Lost(Exception):
    """The gains could not be put anywhere."""


def fail(content: gain_file.GainFile) -> None:
    raise Lost


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture
def kept(tmp_path: Path) -> Path:
    """Return the checkpoint of a search that has ended and whose gains could not be stored."""
    path = tmp_path / "run.npz"
    with pytest.raises(Lost):
        tune(ARM, QUICK, checkpoint=path, store=fail)
    return path


@pytest.fixture
def underway(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the checkpoint of a search that was cut off in its second half."""
    monkeypatch.setattr(search_module, "PERIOD_S", -1.0)
    path = tmp_path / "run.npz"

    def cut(report: Report) -> None:
        if report.evaluations > 80:
            raise Lost

    with pytest.raises(Lost):
        tune(ARM, QUICK, checkpoint=path, report=cut)
    return path


def changed(path: Path, *, sealed: bool, **arrays: Any) -> None:
    """Put other arrays into a checkpoint, with a checksum that belongs to them if `sealed`."""
    stored = dict(np.load(path)) | {name: np.asarray(value) for name, value in arrays.items()}
    if sealed:
        stored["checksum"] = np.array(checkpoint_module._checksum(stored))
    np.savez(path, **stored)


def test_a_search_that_has_ended_is_kept_until_its_gains_are(kept: Path) -> None:
    stored: list[gain_file.GainFile] = []

    def store(content: gain_file.GainFile) -> None:
        assert kept.exists()
        stored.append(content)

    def never(report: Report) -> None:
        raise AssertionError("the search began anew")

    content = tune(ARM, QUICK, checkpoint=kept, resume=True, store=store, report=never)
    assert stored == [content] and not kept.exists()
    assert content == tune(ARM, QUICK)


def test_a_leg_is_kept_only_if_it_is_better() -> None:
    class Tuner:
        evaluations = 10

    progress = Progress(identity={})
    for name, score in [("a", (3.0, 5, 1)), ("b", (2.0, 7, 1)), ("c", (2.5, 9, 1))]:
        progress.end_leg(Tuner(), {"B": name}, score)  # type: ignore[arg-type]
    assert (progress.leg, progress.evaluations) == (3, 30)
    assert (progress.gains, progress.cost, progress.solved) == ({"B": "b"}, 2.0, 7)


def test_checkpoints_of_another_geometry_or_version_are_refused(
    kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dh = ARM.dh
    assert dh is not None

    def other(**changes: float) -> ik.Robot:
        """Return an arm of the same name and limits with another last row."""
        rows = [{"a": r.a, "alpha": r.alpha, "d": r.d, "theta": r.theta} for r in dh]
        rows[-1] |= changes
        limits = np.column_stack((ARM.lower, ARM.upper))
        names = list(ARM.joint_names)
        return ik.Robot.from_dh(rows, limits=limits, joint_names=names, name=ARM.name)

    longer = other(a=dh[-1].a + 1e-6)
    for arm in (longer, ARM.with_tool(np.diag([1.0, -1.0, -1.0, 1.0]))):
        with pytest.raises(GainFileError, match="another run: geometry"):
            tune(arm, QUICK, checkpoint=kept, resume=True)
    monkeypatch.setattr(plan_module, "__version__", "0.0.1")
    with pytest.raises(GainFileError, match=r"another run: version '.*', not '0\.0\.1'"):
        tune(ARM, QUICK, checkpoint=kept, resume=True)


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"identity": "[1]"}, "'identity' holds \\[1\\], expected a table"),
        ({"identity": "{"}, "'identity' is no JSON"),
        ({"identity": "[" * 100_000}, "'identity' is no JSON: nested too deep"),
        ({"identity": 3}, "'identity' of shape \\(\\), dtype\\('int64'\\), expected a text"),
        ({"counts": [99, 160, 1]}, "'counts': 99 ended searches, expected 0 to 2"),
        ({"counts": [-1, 0, 0]}, "'counts': -1 ended searches"),
        ({"counts": [2, 10**12, 1]}, "'counts': 1000000000000 gain sets judged, expected 160"),
        ({"counts": [2, 0, 1]}, "'counts': 0 gain sets judged, expected 160"),
        ({"counts": [2, 160, 10_001]}, "'counts': 10001 of 10000 goals reached"),
        ({"counts": [1, 2]}, "'counts' of shape \\(2,\\)"),
        ({"counts": [0.5, 1.0, 1.0]}, "'counts' of shape .*expected \\(3,\\), integers"),
        ({"cost": np.nan}, "'cost': nan, expected a finite number >= 0"),
        ({"cost": -1.0}, "'cost': -1.0, expected a finite number >= 0"),
        ({"cost": [1.0]}, "'cost' of shape \\(1,\\)"),
        ({"gains": "null"}, "'gains' holds None, expected a table"),
        ({"gains": '{"Z": [1]}'}, "'gains': \\['Z'\\], expected A, B, C"),
        (
            {"gains": '{"A": 1, "B": 1, "C": 1}'},
            "'gains': A of shape \\(\\), expected \\(\\d, \\d\\)",
        ),
        ({"gains": '{"A": NaN, "B": "x", "C": 1}'}, "'gains': A of shape"),
        ({"state": "x"}, "'state' of shape \\(\\), <U1, expected \\(n,\\), float64"),
        ({"state": np.zeros((2, 2))}, "'state' of shape \\(2, 2\\)"),
    ],
)
def test_tampered_checkpoints_are_refused_by_name(
    kept: Path, arrays: dict[str, Any], message: str
) -> None:
    # The checksum belongs to the content: each check stands for itself.
    changed(kept, sealed=True, **arrays)
    with pytest.raises(GainFileError, match=message) as caught:
        tune(ARM, QUICK, checkpoint=kept, resume=True)
    assert str(caught.value).startswith(f"{kept}: ") and "\n" not in str(caught.value)


def test_other_content_than_was_written_is_refused(kept: Path) -> None:
    stored = dict(np.load(kept))
    gains = json.loads(str(stored["gains"]))
    gains["B"][0][0] += 1e-12
    for arrays in (
        {"gains": json.dumps(gains)},
        {"cost": float(stored["cost"]) / 2},
        {"counts": stored["counts"] - [0, 0, 1]},
    ):
        changed(kept, sealed=False, **{**stored, **arrays})
        with pytest.raises(GainFileError, match="its checksum belongs to other content"):
            tune(ARM, QUICK, checkpoint=kept, resume=True)
    identity = json.loads(str(stored["identity"])) | {"extra": 1}
    changed(kept, sealed=True, **{**stored, "identity": json.dumps(identity)})
    with pytest.raises(GainFileError, match="another run: extra 1, not None"):
        tune(ARM, QUICK, checkpoint=kept, resume=True)


def test_states_of_a_search_underway_are_checked(underway: Path) -> None:
    state = np.load(underway)["state"]
    assert len(state) > 10
    whole = underway.read_bytes()
    for other in (state[:-1], np.full_like(state, np.nan), np.r_[state, state], -state):
        underway.write_bytes(whole)
        changed(underway, sealed=False, state=other)
        with pytest.raises(GainFileError, match="its checksum belongs to other content"):
            tune(ARM, QUICK, checkpoint=underway, resume=True)
    underway.write_bytes(whole)
    assert tune(ARM, QUICK, checkpoint=underway, resume=True) == tune(ARM, QUICK)


def test_a_disk_that_refuses_the_checkpoint_does_not_end_the_search(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(search_module, "PERIOD_S", -1.0)

    def refuse(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", refuse)
    said: list[str] = []
    path = tmp_path / "run.npz"
    content = tune(ARM, QUICK, checkpoint=path, report=lambda report: said.append(report.unsaved))
    assert said[0] == "" and "run.npz: cannot be written: no space left" in said[-1]
    assert content == tune(ARM, QUICK)
    assert list(tmp_path.iterdir()) == []


# ---- the command --------------------------------------------------------------------------------

COMMAND = [sys.executable, "-m", "agrik_fast.cli", "tune", "hydrolek", "-o", "g.toml"]
SHORT = ["--goals", "20", "--evaluations", "80", "--runs", "1", "--refinement", "0"]


def run(folder: Path, *words: str, **options: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*COMMAND, *SHORT, *words],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        **options,
    )


def test_gains_that_cannot_be_written_at_the_end_are_kept_in_the_checkpoint(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "f"
    folder.mkdir()
    # Long enough to be overtaken: another program makes the gain file while the search runs.
    words = ["--goals", "400", "--evaluations", "400"]
    process = subprocess.Popen(
        [*COMMAND, *SHORT, *words], cwd=folder, stderr=subprocess.PIPE, text=True
    )
    assert process.stderr is not None
    process.stderr.readline()
    (folder / "g.toml").write_text("another's")
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 2 and "Traceback" not in errors
    last = errors.splitlines()[-1]
    assert "g.toml: exists already" in last
    assert "the search is kept in g.toml.checkpoint.npz (--resume goes on with it)" in last
    assert (folder / "g.toml").read_text() == "another's"
    assert names(folder) == ["g.toml", "g.toml.checkpoint.npz"]
    (folder / "g.toml").unlink()
    done = run(folder, *words, "--resume")
    assert done.returncode == 0, done.stderr
    assert gain_file.read(folder / "g.toml").robot == "hydrolek"
    assert names(folder) == ["g.toml"]


def test_gains_are_told_where_no_file_can_be_written(tmp_path: Path) -> None:
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (512, 512))  # noqa: E731
    done = run(tmp_path, preexec_fn=limit)
    assert done.returncode == 2 and "Traceback" not in done.stderr
    last = done.stderr.splitlines()[-1]
    assert last.endswith(
        "g.toml: cannot be written: file too large; its text is on standard output"
    )
    assert names(tmp_path) == []
    (tmp_path / "told.toml").write_text(done.stdout)
    assert gain_file.read(tmp_path / "told.toml").robot == "hydrolek"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_cut_search_says_where_it_is_kept(tmp_path: Path, number: signal.Signals) -> None:
    words = [*SHORT, "--goals", "2000", "--evaluations", "100000"]
    process = subprocess.Popen([*COMMAND, *words], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    for _ in range(600):
        if (tmp_path / "g.toml.checkpoint.npz").exists():
            break
        time.sleep(0.1)
    process.send_signal(number)
    _, errors = process.communicate(timeout=60)
    word = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated", signal.SIGHUP: "hung up"}
    assert process.returncode == 128 + number
    kept = "the search is kept in g.toml.checkpoint.npz (--resume goes on with it)"
    assert errors.splitlines()[-1] == f"agrik-fast: {word[number]}, {kept}"


def test_a_folder_that_cannot_be_written_is_told_before_the_search(tmp_path: Path) -> None:
    (tmp_path / "g.toml").write_text("old")
    (tmp_path / "g.toml").chmod(0o444)
    start = time.monotonic()
    done = run(tmp_path, "--force", "--evaluations", "1000000000")
    assert time.monotonic() - start < 60
    assert (done.returncode, (tmp_path / "g.toml").read_text()) == (2, "old")
    assert "the file is read-only" in done.stderr and len(done.stderr.splitlines()) == 1


def test_quick_is_what_the_counts_above_are_of() -> None:
    assert dataclasses.replace(QUICK, evaluations=80) == QUICK
    assert [leg.evaluations for leg in plan_module.legs_of(QUICK)] == [80, 80]
