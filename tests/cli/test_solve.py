"""`agrik-fast solve`: its files, messages and exit codes."""

import io
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from agrik_fast import ArgumentError, Robot, Status
from agrik_fast.cli._solve import parse_axis
from agrik_fast.cli.progress import Bar, Plain, for_stream
from agrik_fast.cli.summary import print_summaries
from agrik_fast.io import read_results
from agrik_fast.io._results import RESULT_SUFFIXES
from agrik_fast.jobs import SolveRequest, solve_file
from agrik_fast.jobs import _pipeline as pipeline
from agrik_fast.jobs import _solve_file as solve_module
from cli_runner import RunCommand, one_line, run_command


@pytest.fixture
def agrik_fast(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RunCommand:
    """Run the command in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return run_command


def points_file(name: str, robot: str, count: int, seed: int = 0) -> np.ndarray:
    arm = Robot.load(robot)
    points = arm.fk(arm.random_q(count, seed))[:, :3, 3]
    np.save(name, points)
    return points


# ---- solving -----------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", RESULT_SUFFIXES)
def test_results_are_those_of_one_call(
    agrik_fast: RunCommand, suffix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Small pieces and small writes, so that many of both are put together.
    monkeypatch.setattr(pipeline, "FIRST_PIECE", 3)
    monkeypatch.setattr(pipeline, "LARGEST_PIECE", 17)
    monkeypatch.setattr(solve_module, "WRITE_ROWS", 50)
    points = points_file("points.npy", "hydrolek", 300)
    result = agrik_fast("solve", "hydrolek", "points.npy", "-o", f"out{suffix}", "--seed", 5)
    assert result.exit_code == 0, result.output
    layout, rows = read_results(f"out{suffix}")
    whole = Robot.load("hydrolek").ik(points, seed=5)
    names = Robot.load("hydrolek").joint_names
    assert layout.joint_columns == tuple(f"{name}_rad" for name in names)
    np.testing.assert_array_equal(rows.q, whole.q)
    np.testing.assert_array_equal(rows.status, whole.status)
    np.testing.assert_array_equal(rows.success, whole.success)
    np.testing.assert_array_equal(rows.position_error, whole.position_error)
    np.testing.assert_array_equal(rows.iterations, whole.iterations)
    np.testing.assert_array_equal(rows.restarts, whole.restarts)
    assert rows.ids.astype(int).tolist() == list(range(1, 301))


def test_units_do_not_change_the_answer(agrik_fast: RunCommand) -> None:
    Path("mm.csv").write_text("x_mm,y_mm,z_mm\n426,345,-331.614\n520,350,-298.6\n")
    Path("m.csv").write_text("x_m,y_m,z_m\n0.426,0.345,-0.331614\n0.52,0.35,-0.2986\n")
    for name in ("mm", "m"):
        assert agrik_fast("solve", "strawberry", f"{name}.csv", "-o", f"{name}.npz").exit_code == 0
    (layout, one), (_, other) = read_results("mm.npz"), read_results("m.npz")
    assert layout.joint_columns == ("s10_m", "s21_m", "s32_m", "theta_rad", "beta_rad")
    assert one.success.all()
    # -331.614 / 1000 and -0.331614 differ in the last bit.
    np.testing.assert_allclose(one.q, other.q, rtol=1e-12)


def test_pose_task_from_zyz_angles(agrik_fast: RunCommand) -> None:
    Path("pose.csv").write_text(
        "id,x_mm,y_mm,z_mm,zyz_alpha_deg,zyz_beta_deg,zyz_gamma_deg\np1,334,471,539,90,45,30\n"
    )
    result = agrik_fast("solve", "redundant7", "pose.csv", "-o", "out.csv")
    assert result.exit_code == 0, result.output
    _, rows = read_results("out.csv")
    assert rows.ids.tolist() == ["p1"]
    assert rows.success.all()
    # Any solution of the paper's target has this elbow angle.
    assert abs(rows.q[0, 3]) == pytest.approx(1.7293153436, abs=1e-4)
    # The same file as a position task is solved without regard to the angles.
    words = ("solve", "redundant7", "pose.csv", "-o", "p.csv", "--task", "position")
    assert agrik_fast(*words).exit_code == 0


def test_axis_task(agrik_fast: RunCommand) -> None:
    Path("grip.csv").write_text("x_m,y_m,z_m\n0.6,0.0,1.0\n")
    words = ["solve", "cucumber", "grip.csv", "-o", "out.npz", "--task", "axis"]
    result = agrik_fast(*words, "--tool-axis", "x", "--direction", "-z")
    assert result.exit_code == 0, result.output
    _, rows = read_results("out.npz")
    assert rows.success.all()
    pose = Robot.load("cucumber").fk(rows.q[0])
    np.testing.assert_allclose(pose[:3, 0], [0, 0, -1], atol=2e-6)
    np.testing.assert_allclose(pose[:3, 3], [0.6, 0, 1], atol=2e-6)
    vector = agrik_fast(*words, "--tool-axis", "2,0,0", "--direction", "0,0,-1", "--force")
    assert vector.exit_code == 0, vector.output
    np.testing.assert_array_equal(read_results("out.npz")[1].q, rows.q)


@pytest.mark.parametrize(
    ("text", "vector"),
    [("x", (1, 0, 0)), ("-y", (0, -1, 0)), ("+Z", (0, 0, 1)), ("0, 3,-4", (0, 3, -4))],
)
def test_axes_by_name_or_numbers(text: str, vector: tuple[int, int, int]) -> None:
    assert parse_axis("direction", text) == vector


@pytest.mark.parametrize("text", ["w", "", "1,2", "0,0,0", "nan,0,1", "1,2,3,4", "--x"])
def test_odd_axes_are_refused(text: str) -> None:
    with pytest.raises(ArgumentError, match="direction"):
        parse_axis("direction", text)


def test_bad_rows_leave_the_others_unharmed(agrik_fast: RunCommand) -> None:
    points = points_file("good.npy", "tomato", 20)
    np.save("bad.npy", np.insert(points, [3, 11], [[np.nan, 0, 0], [np.inf, 0, 0]], axis=0))
    assert agrik_fast("solve", "tomato", "good.npy", "-o", "good.npz").exit_code == 0
    result = agrik_fast("solve", "tomato", "bad.npy", "-o", "bad.npz")
    assert result.exit_code == 0, result.output
    _, good = read_results("good.npz")
    _, bad = read_results("bad.npz")
    at = [3, 12]
    assert bad.status[at].tolist() == [Status.BAD_INPUT] * 2
    assert not bad.success[at].any()
    assert good.success.all()
    assert np.delete(bad.success, at).all()
    # Rows before the first bad one even keep their index and with it their random stream.
    np.testing.assert_array_equal(bad.q[:3], good.q[:3])


def test_strict_and_the_summary(agrik_fast: RunCommand) -> None:
    Path("t.csv").write_text("x_m,y_m,z_m\n0.2,0.0,0.1\n9,0,0\nnan,0,0\n")
    plain = agrik_fast("solve", "tomato", "t.csv", "-o", "a.csv")
    assert plain.exit_code == 0, plain.output
    strict = agrik_fast("solve", "tomato", "t.csv", "-o", "b.csv", "--strict")
    assert strict.exit_code == 3
    assert Path("a.csv").read_bytes() == Path("b.csv").read_bytes()
    heading, row, place = plain.stdout.splitlines()
    names = ["robot", "task", "rows", "solved", "out of reach", "not found", "bad input"]
    names += ["median m", "worst m", "median rad", "worst rad", "time s", "solves/s"]
    assert re.split(r"\s{2,}", heading) == names
    cells = dict(zip(names, re.split(r"\s{2,}", row), strict=True))
    assert [cells[name] for name in names[:7]] == ["tomato", "position", "3", "1", "1", "0", "1"]
    assert float(cells["worst m"]) <= 1e-6
    assert cells["median rad"] == "-"
    assert place == "results: a.csv"
    assert "tomato, position task" in plain.stderr
    _, rows = read_results("a.csv")
    assert [Status(code).name for code in rows.status] == ["CONVERGED", "OUT_OF_REACH", "BAD_INPUT"]


def test_unused_columns_are_mentioned(agrik_fast: RunCommand) -> None:
    Path("t.csv").write_text("x_m,y_m,z_m,colour\n0.2,0,0.1,red\n")
    assert "not used: colour" in agrik_fast("solve", "tomato", "t.csv", "-o", "r.csv").stderr


def test_tolerances_by_axis(agrik_fast: RunCommand) -> None:
    arm = Robot.load("puma560")
    poses = arm.fk(arm.random_q(20, seed=2))
    poses[:, 2, 3] += 0.02
    np.save("off.npy", poses)
    words = ["solve", "puma560", "off.npy", "-o", "out.npz", "--strict"]
    bounds = ["--tol", "1e-6,1e-6,0.021", "--tol-rad", "0.001,0.002,inf", "--tol-frame", "base"]
    assert agrik_fast(*words, *bounds).exit_code == 0
    layout = read_results("out.npz")[0]
    assert layout.metadata["position_tolerance_m"] == "1e-06,1e-06,0.021"
    assert layout.metadata["orientation_tolerance_rad"] == "0.001,0.002,inf"
    assert layout.metadata["tolerance_frame"] == "base"
    wrong = {
        "--tol": ["1,2", "a", "1,2,3,4", "nan,1,1", "-1", "inf", "1,0,1"],
        "--tol-rad": ["", "1;2;3"],
        "--tol-frame": ["world"],
    }
    for option, values in wrong.items():
        for value in values:
            refused = agrik_fast(*words, "--force", option, value)
            assert refused.exit_code == 2
            assert f"`{option}`" in refused.stderr


def test_the_position_first(agrik_fast: RunCommand) -> None:
    arm = Robot.load("hydrolek")
    np.save("poses.npy", arm.fk(arm.random_q(20, seed=2)))
    words = ["solve", "hydrolek", "poses.npy", "-o", "out.npz", "--task", "position-first"]
    assert agrik_fast(*words, "--strict").exit_code == 0
    np.save("points.npy", np.zeros((2, 3)))
    words[2] = "points.npy"
    refused = agrik_fast(*words, "--force")
    assert refused.exit_code == 2
    assert "orientations" in refused.stderr


def test_tolerance_and_solver_are_passed_on(agrik_fast: RunCommand) -> None:
    points_file("p.npy", "tomato", 50)
    words = ["solve", "tomato", "p.npy", "--solver", "transpose", "--tol", "1e-3"]
    assert agrik_fast(*words, "-o", "r.npz", "--threads", 1).exit_code == 0
    layout, rows = read_results("r.npz")
    assert layout.metadata["solver"] == "transpose"
    assert layout.metadata["position_tolerance_m"] == "0.001"
    assert 1e-6 < rows.position_error[rows.success].max() <= 1e-3


# ---- messages ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["tomatoe", "t.csv", "-o", "r.csv"], "unknown robot 'tomatoe'; did you mean 'tomato'?"),
        (["tomato", "t.csv", "-o", "r.csv", "--solver", "ml"], "unknown solver 'ml'"),
        (["tomato", "t.csv", "-o", "r.csv", "--task", "poze"], "unknown task 'poze'"),
        (["tomato", "t.csv", "-o", "r.csv", "--task", "pose"], "orientations for a pose task"),
        (["tomato", "t.csv", "-o", "r.csv", "--task", "axis"], "`--direction`: expected one, as"),
        (["tomato", "t.csv", "-o", "r.csv", "--direction", "z"], "expected task 'axis'"),
        (["tomato", "t.csv", "-o", "r.csv", "--tol", "-1"], "`--tol`: expected a positive number"),
        (["tomato", "t.csv", "-o", "r.csv", "--tol", "0"], "`--tol`: expected a positive number"),
        (["tomato", "t.csv", "-o", "r.csv", "--tol-rad", "1,0,1"], "expected a positive number"),
        (["tomato", "t.csv", "-o", "r.csv", "--tol-rad", "nan"], "expected a positive number"),
        (["tomato", "t.csv", "-o", "r.doc"], "r.doc: unknown suffix '.doc', expected one of .csv"),
        (["tomato", "t.doc", "-o", "r.csv"], "t.doc: unknown suffix '.doc', expected one of .csv"),
        (["tomato", "none.csv", "-o", "r.csv"], "none.csv: cannot be read: no such file"),
        (["tomato", "empty.csv", "-o", "r.csv"], "empty.csv: the file is empty"),
        (["tomato", "mixed.csv", "-o", "r.csv"], "mixed.csv: mixed units in the position columns"),
        (["tomato", "short.csv", "-o", "r.csv"], "short.csv: missing column 'z_m'"),
        (
            ["tomato", "text.csv", "-o", "r.csv"],
            "text.csv: row 2 (line 3), column 'y_m': expected a number, got 'abc'",
        ),
        (["tomato", "t.csv", "-o", "no/r.csv"], "r.csv: cannot be written: no such file or dir"),
        (["tomato", "t.csv", "-o", "there.csv"], "there.csv: exists already (use --force"),
        (["tomato", "t.csv", "-o", "t.csv", "--force"], "t.csv: is the target file"),
    ],
)
def test_faults_are_one_line_and_code_2(
    agrik_fast: RunCommand, words: list[str], message: str
) -> None:
    good = "x_m,y_m,z_m\n0.2,0.0,0.1\n"
    files = {
        "t.csv": good,
        "empty.csv": "",
        "mixed.csv": "x_m,y_mm,z_m\n1,2,3\n",
        "short.csv": "x_m,y_m\n1,2\n",
        "text.csv": good + "0.2,abc,0.1\n",
        "there.csv": "old",
    }
    for name, text in files.items():
        Path(name).write_text(text)
    result = agrik_fast("solve", *words)
    error = result.stderr.strip().splitlines()
    assert result.exit_code == 2, result.output
    assert message in error[-1]
    assert "Traceback" not in result.output
    assert {entry.name: entry.read_text() for entry in Path().iterdir()} == files


def test_most_faults_are_seen_before_anything_is_solved(agrik_fast: RunCommand) -> None:
    Path("t.csv").write_text("x_m,y_m,z_m\n1,2,3\n")
    Path("r.csv").write_text("old")
    assert "exists already" in one_line(agrik_fast("solve", "tomato", "t.csv", "-o", "r.csv"))


@pytest.mark.parametrize(
    "words", [["solve", "tomato"], ["solve", "tomato", "t.csv"], ["cook"], ["solve", "--tol", "x"]]
)
def test_wrong_usage_is_code_2(agrik_fast: RunCommand, words: list[str]) -> None:
    result = agrik_fast(*words)
    assert result.exit_code == 2
    assert result.stderr.startswith("agrik-fast: ") and len(result.stderr.splitlines()) == 1


def test_the_force_option_replaces(agrik_fast: RunCommand) -> None:
    Path("t.csv").write_text("x_m,y_m,z_m\n0.2,0.0,0.1\n")
    Path("r.csv").write_text("old")
    assert agrik_fast("solve", "tomato", "t.csv", "-o", "r.csv", "--force").exit_code == 0
    assert Path("r.csv").read_text().startswith("id,phi1_rad,phi2_rad,phi3_rad,status,")


# ---- Ctrl-C ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("number", "code", "word"),
    [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated")],
)
def test_a_signal_stops_and_leaves_the_file_untouched(
    tmp_path: Path, number: signal.Signals, code: int, word: str
) -> None:
    # Reachable points whose orientation is turned about the forearm, which the arm cannot
    # do and no bound tells: every row costs all its restarts.
    arm = Robot.load("tomato")
    angle = np.random.default_rng(0).uniform(0.5, 2.5, 200_000)
    turn = np.tile(np.eye(4), (len(angle), 1, 1))
    turn[:, 1, 1] = turn[:, 2, 2] = np.cos(angle)
    turn[:, 2, 1] = np.sin(angle)
    turn[:, 1, 2] = -turn[:, 2, 1]
    np.save(tmp_path / "hard.npy", arm.fk(arm.random_q(len(angle))) @ turn)
    result = tmp_path / "r.csv"
    result.write_text("old")
    words = ["solve", "tomato", "hard.npy", "-o", "r.csv", "--force", "--solver", "transpose"]
    job = subprocess.Popen(
        [sys.executable, "-m", "agrik_fast.cli", *words],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert job.stderr is not None
        assert "tomato, pose task" in job.stderr.readline()
        time.sleep(0.5)
        assert job.poll() is None
        assert [entry.name for entry in tmp_path.glob(".r.csv.*.partial")]
        job.send_signal(number)
        # One second is the promise; a busy machine gets more before it counts as hanging.
        _, errors = job.communicate(timeout=20)
    finally:
        job.kill()
    assert job.returncode == code
    assert f"agrik-fast: {word}, nothing was written" in errors
    assert "Traceback" not in errors
    assert result.read_text() == "old"
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["hard.npy", "r.csv"]


def test_a_failing_writer_stops_the_solver(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    np.save(tmp_path / "p.npy", np.full((5_000, 3), 0.15))
    monkeypatch.setattr(solve_module, "WRITE_ROWS", 1)

    class FullDisk(Exception):
        pass

    def fail(self: object, chunk: object) -> None:
        raise FullDisk

    monkeypatch.setattr("agrik_fast.io._csv_results.CsvWriter._write", fail)
    with pytest.raises(FullDisk):
        solve_file(SolveRequest("tomato", tmp_path / "p.npy", tmp_path / "r.csv"))
    assert [entry.name for entry in tmp_path.iterdir()] == ["p.npy"]


# ---- progress ----------------------------------------------------------------------------------


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_terminal_gets_a_bar_and_a_ruled_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    np.save(tmp_path / "p.npy", np.full((40, 3), 0.15))
    stream = Terminal()
    bar = for_stream(stream)
    assert isinstance(bar, Bar)
    request = SolveRequest("tomato", tmp_path / "p.npy", tmp_path / "r.csv")
    summary = solve_file(request, bar)
    assert "tomato, position task" in stream.getvalue()
    assert "40/40" in stream.getvalue()

    def shown(count: int, columns: int) -> list[str]:
        monkeypatch.setenv("TERM", "xterm")
        monkeypatch.setenv("COLUMNS", str(columns))
        table = Terminal()
        print_summaries([summary] * count, table)
        lines = re.sub(r"\x1b\[[0-9;]*m", "", table.getvalue()).splitlines()
        assert max(map(len, lines)) <= columns
        assert "…" not in table.getvalue()
        return lines

    one = shown(1, 80)
    assert "┃" in one[1]
    assert any("solved" in line and "40" in line for line in one)
    wide = shown(2, 160)
    assert "median m" in wide[1]
    narrow = shown(2, 80)
    assert narrow[0].startswith("tomato, position: 40 rows, 40 solved, 0 out of reach, ")


def test_a_log_gets_plain_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    lines = for_stream(stream)
    assert isinstance(lines, Plain)
    now = iter([0.0, 1.0, 2.5, 3.0, 9.0])
    monkeypatch.setattr(time, "monotonic", lambda: next(now))
    with lines:
        lines.start("job", 100)
        for rows in (10, 20, 30, 40):
            lines.advance(rows)
    assert stream.getvalue() == "job: 100 rows\n30 of 100 rows done\n100 of 100 rows done\n"
