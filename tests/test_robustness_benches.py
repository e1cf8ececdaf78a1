"""The fuzzer's and the robustness page's own parts: a judge that sees nothing finds no fault."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import agrik_fast as ik
import numpy_fk
from agrik_fast import Status

BENCHES = Path(__file__).resolve().parent.parent / "benches"
DATA = Path(__file__).resolve().parent / "data"


@pytest.fixture(scope="module")
def robust() -> Iterator[SimpleNamespace]:
    """Return the modules of `benches/robust`."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(BENCHES))
        from robust import (
            arms,
            building,
            cases,
            chain,
            files,
            judge,
            measure,
            page,
            pool,
            postures,
            requests,
        )

        modules = (
            arms,
            building,
            cases,
            chain,
            files,
            judge,
            measure,
            page,
            pool,
            postures,
            requests,
        )
        yield SimpleNamespace(**{_last(module): module for module in modules})


def _last(module: ModuleType) -> str:
    return module.__name__.rpartition(".")[2]


# ---- kinematics ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ik.Robot.names())
def test_bundled_arms_are_where_another_reader_has_them(robust: Any, name: str) -> None:
    arm, robot = robust.files.bundled(name)
    q = robot.random_q(50, seed=1)
    np.testing.assert_allclose(arm.fk(q), numpy_fk.fk(name, q), rtol=0, atol=1e-14)
    low, high = numpy_fk.limits(name).T
    np.testing.assert_array_equal(arm.lower, low)
    np.testing.assert_array_equal(arm.upper, high)


@pytest.mark.parametrize("name", ["iiwa14", "irb140", "kr16"])
def test_urdfs_are_read_as_the_library_reads_them(robust: Any, name: str) -> None:
    text = (DATA / f"{name}.urdf").read_text(encoding="utf-8")
    robot = ik.Robot.from_urdf(text)
    arm = robust.files.read_urdf(name, text, None, robot.link_names[-2])
    arm = arm.ordered(robot.joint_names)
    q = robot.random_q(50, seed=1)
    np.testing.assert_allclose(arm.fk(q), robot.fk(q), rtol=0, atol=1e-13)
    np.testing.assert_array_equal(arm.lower, robot.lower)


def test_angles_far_out_are_exact(robust: Any) -> None:
    # cos and sin of 1e16 rad by 40-digit arithmetic; the joint stands behind a turn of 1 rad.
    cosine, sine = -0.6261681981330862, 0.7796880066069787
    rows = np.array([[2.0, 0.0, 0.0, 1.0]])
    arm = robust.building.from_dh(
        rows, "standard", ["revolute"], [(-2e16, 2e16)], np.eye(4), np.eye(4), "one", 1.0
    )
    point = arm.fk([[1e16]])[0, :2, 3] / 2
    expected = [
        cosine * np.cos(1) - sine * np.sin(1),
        sine * np.cos(1) + cosine * np.sin(1),
    ]
    np.testing.assert_allclose(point, expected, rtol=0, atol=4e-16)


def test_rotation_vectors_up_to_half_a_turn(robust: Any) -> None:
    rng = np.random.default_rng(2)
    for angle in (0.0, 1e-12, 1e-6, 1.0, 3.0, np.pi - 1e-9):
        axis = robust.chain.unit(rng.normal(size=3))
        vector = robust.chain.rotation_vectors(robust.chain.rotation(axis, angle)[None])[0]
        np.testing.assert_allclose(vector, angle * axis, rtol=0, atol=2e-15 + 1e-8 * (angle > 3.1))


def test_roll_pitch_yaw_there_and_back(robust: Any) -> None:
    rng = np.random.default_rng(3)
    turns = [robust.chain.random_rotation(rng) for _ in range(30)]
    turns += [robust.chain.from_rpy((0.3, pitch, -1.0)) for pitch in (np.pi / 2, -np.pi / 2)]
    for turn in turns:
        again = robust.chain.from_rpy(robust.chain.to_rpy(turn))
        np.testing.assert_allclose(again, turn, rtol=0, atol=2e-15)


@pytest.mark.filterwarnings("ignore::agrik_fast.errors.RobotWarning")  # joints that cannot move
def test_random_arms_are_of_every_kind_and_where_the_library_has_them(robust: Any) -> None:
    seen, compared = set(), 0
    for number in range(150):
        rng = np.random.default_rng([5, number])
        arm = robust.arms.draw(rng)
        seen.add(arm.kind)
        try:
            robot = robust.building.library_arm(arm)
        except ik.AgrikError:
            continue
        arm = arm.ordered(robot.joint_names)
        q = robust.postures.draw(arm, "random", 5, rng)
        size = 1e-11 * (1 + arm.length + np.abs(q).max())
        np.testing.assert_allclose(arm.fk(q), robot.fk(q), rtol=0, atol=size)
        compared += 1
    assert seen == set(robust.arms.KINDS)
    assert compared > 120


def test_postures_are_within_the_limits_and_of_their_kind(robust: Any) -> None:
    arm, _ = robust.files.bundled("cucumber")
    rng = np.random.default_rng(4)
    drawn = {kind: robust.postures.draw(arm, kind, 400, rng) for kind in robust.postures.KINDS}
    for q in drawn.values():
        assert robust.judge.within_limits(arm, q).all()
    corners = (drawn["at limits"] == arm.lower) | (drawn["at limits"] == arm.upper)
    assert 0.7 < corners.mean() < 0.9
    right = np.isin(drawn["structured"][:, arm.turns], [0.0, np.pi / 4, np.pi / 2, -np.pi / 2])
    assert 0.3 < right.mean() < 0.6


# ---- the judge -----------------------------------------------------------------------------------


def asked(robust: Any, **options: Any) -> tuple[Any, SimpleNamespace]:
    """Return a request of 20 poses to puma560 and its answer, to be spoilt."""
    arm, robot = robust.files.bundled("puma560")
    q = robot.random_q(20, seed=6)
    poses = arm.fk(q)
    request = robust.requests.Request(
        arm=arm,
        task="pose",
        task_name="pose",
        solver="lm",
        solver_name="lm",
        targets=poses,
        poses=poses,
        reachable=np.ones(20, bool),
        made_from=q,
        q0=q.copy(),
        options=options,
    )
    result = robot.ik(**request.piece(0, 20)())
    fields = {name: np.array(getattr(result, name)) for name in ("success", *robust.judge.FIELDS)}
    return request, SimpleNamespace(**fields)


def test_right_answers_have_no_fault(robust: Any) -> None:
    request, result = asked(robust)
    assert result.success.all()
    assert robust.judge.answers(request, result) == []


def _claim(result: SimpleNamespace, request: Any) -> None:
    result.q[3, 0] = np.clip(result.q[3, 0] + 1e-4, request.arm.lower[0], request.arm.upper[0])


def _leave_limits(result: SimpleNamespace, request: Any) -> None:
    result.q[3, 2] = np.nextafter(request.arm.upper[2], np.inf)


def _prove(result: SimpleNamespace, request: Any) -> None:
    result.status[3], result.success[3] = Status.OUT_OF_REACH, False


def _lose(result: SimpleNamespace, request: Any) -> None:
    result.q[3, 1] = np.nan


def _disown(result: SimpleNamespace, request: Any) -> None:
    result.status[3], result.success[3] = Status.NOT_FOUND, False


def _contradict(result: SimpleNamespace, request: Any) -> None:
    result.success[3] = False


def _misreport(result: SimpleNamespace, request: Any) -> None:
    result.position_error[3] += 1e-8


def _invent(result: SimpleNamespace, request: Any) -> None:
    result.status[3], result.success[3] = Status.BAD_INPUT, False


def _spoil_target(result: SimpleNamespace, request: Any) -> None:
    request.targets[3, 0, 3] = np.nan


def _wind_up(result: SimpleNamespace, request: Any) -> None:
    # The start moves to where another turn of a joint is nearer, within the limits.
    row, joint = np.argwhere(result.q + 2 * np.pi <= request.arm.upper)[0]
    request.q0[row, joint] = result.q[row, joint] + 2 * np.pi


SPOILT: dict[str, Callable[[SimpleNamespace, Any], None]] = {
    "false success": _claim,
    "limits left": _leave_limits,
    "false proof": _prove,
    "not a number": _lose,
    "solution not claimed": _disown,
    "success and status differ": _contradict,
    "error told wrong": _misreport,
    "bad input invented": _invent,
    "bad input not told": _spoil_target,
    "turn further than need be": _wind_up,
}


@pytest.mark.parametrize("kind", SPOILT)
def test_every_kind_of_fault_is_found(robust: Any, kind: str) -> None:
    request, result = asked(robust)
    SPOILT[kind](result, request)
    found = robust.judge.answers(request, result)
    assert kind in {fault.kind for fault in found}
    if kind != "turn further than need be":
        assert {fault.row for fault in found} == {3}


def test_false_branches_are_found(robust: Any) -> None:
    request, _ = asked(robust)
    _, robot = robust.files.bundled("puma560")
    answer = robot.ik_all(request.targets)
    result = SimpleNamespace(
        q=np.array(answer.q), valid=np.array(answer.valid), status=np.array(answer.status)
    )
    assert robust.judge.branches(request, result) == []
    # Branches in which a joint turns freely are branches.
    result.status[6] = Status.SINGULAR_FAMILY
    assert robust.judge.branches(request, result) == []
    result.valid[6] = False
    branch = int(np.flatnonzero(result.valid[4])[0])
    result.q[4, branch, 1] += 1e-4
    result.status[5] = Status.OUT_OF_REACH
    faults = robust.judge.branches(request, result)
    kinds = {fault.kind for fault in faults}
    assert kinds >= {"false success", "false proof", "success and status differ"}
    assert {f.row for f in faults if f.kind == "success and status differ"} == {5, 6}


def test_one_bit_is_seen(robust: Any) -> None:
    _, one = asked(robust)
    _, other = asked(robust)
    assert robust.judge.same(one, other).all()
    other.q[7, 2] = np.nextafter(other.q[7, 2], np.inf)
    other.restarts[9] += 1
    assert np.flatnonzero(~robust.judge.same(one, other)).tolist() == [7, 9]


@pytest.mark.parametrize("task", ["axis", "masked"])
def test_errors_of_tasks_are_those_that_the_library_tells(robust: Any, task: str) -> None:
    arm, robot = robust.files.bundled("redundant7")
    rng = np.random.default_rng(8)
    poses = arm.fk(robot.random_q(40, seed=9))
    for frame in ("base", "tool"):
        made: Any = ik.tasks.Axis(tool_axis=tuple(rng.normal(size=3)))
        if task == "masked":
            made = ik.tasks.Masked((1, 0, 2, 0.5, 1, 0), frame=frame)
        # One step is not enough: the errors left are large.
        solver = ik.solvers.LevenbergMarquardt(max_iterations=1, max_restarts=0)
        result = robot.ik(poses, task=made, solver=solver)
        position, orientation = robust.judge.errors(made, task, arm.fk(result.q), poses)
        assert (position > 1e-3).sum() > 20
        np.testing.assert_allclose(position, result.position_error, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(orientation, result.orientation_error, rtol=1e-9, atol=1e-12)


# ---- cases and processes -------------------------------------------------------------------------


def test_a_case_is_the_same_again(robust: Any) -> None:
    one, other = (robust.cases.run(11, 3) for _ in range(2))
    assert one.counts == other.counts
    assert one.counts["rows"] > 0 and one.counts["rows compared"] > 0
    assert one.faults == other.faults


def test_a_snippet_runs(robust: Any, capsys: pytest.CaptureFixture[str]) -> None:
    from robust.snippet import snippet

    request, _ = asked(robust, tool=np.eye(4))
    arm = robust.building.changed(request.arm)
    code = snippet(arm, request, 2)
    exec(compile(code, "snippet", "exec"), {})
    assert "CONVERGED" in capsys.readouterr().out


FAKES = {
    "hang": "    import time\n    time.sleep(60)\n",
    "crash": "    import os\n    os.abort()\n",
}


@pytest.mark.parametrize("kind", FAKES)
def test_the_watchdog_names_the_case(
    robust: Any, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "robust"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "worker.py").write_text(
        "import json, sys\n"
        "def main(seed, noise):\n"
        "  for line in sys.stdin:\n"
        "    print(json.dumps({'doing': 'the call', 'case': int(line)}), flush=True)\n"
        "    if int(line) == 6:\n  "
        + FAKES[kind].replace("\n    ", "\n      ")
        + "    print(json.dumps({'done': int(line), 'counts': {}, 'tally': {}, 'faults': []}),"
        " flush=True)\n"
    )
    monkeypatch.setattr(robust.pool, "BENCHES", tmp_path)
    found = list(robust.pool.work(1, iter([5, 6, 7]), 1, 8.0))
    assert [each["done"] for each in found] == [5, 6, 7]
    (fault,) = found[1]["faults"]
    assert (fault["kind"], fault["case"], fault["place"]) == (kind, 6, "the call")
    assert not found[2]["faults"]


def test_the_fuzzer_from_the_command_line(tmp_path: Path) -> None:
    faults = tmp_path / "faults.json"
    command = [sys.executable, str(BENCHES / "fuzz_arms.py"), "--rows", "500", "--workers", "1"]
    done = subprocess.run([*command, "--json", str(faults)], capture_output=True, text=True)
    assert "rows solved and judged" in done.stdout, done.stderr
    assert done.returncode == int(bool(json.loads(faults.read_text())))


# ---- the page ------------------------------------------------------------------------------------


def test_a_measurement_and_its_page(robust: Any) -> None:
    pair = robust.files.bundled("puma560")
    found = robust.measure.measure(*pair, "random", "pose", "lm", 60)
    assert found.solved == 60
    assert found.false_successes == found.false_proofs == 0
    beyond = robust.measure.measure(*pair, "out of reach", "position", "auto", 30)
    assert (beyond.solved, beyond.out_of_reach) == (0, 30)
    text = robust.page.write({"Structured postures": [found]}, "the command", 60.0)
    assert "| puma560 | 60 | 100 % |" in text
    assert "the command" in text


def test_a_spoilt_measurement_is_told(robust: Any) -> None:
    pair = robust.files.bundled("puma560")
    found = robust.measure.measure(*pair, "structured", "pose", "lm", 30)
    found.faults["false success"] = 2
    found.example["false success"] = "row 4"
    found.solved = 29
    text = robust.page.write({"Structured postures": [found]}, "the command", 60.0)
    assert "2 false successes" in text
    assert "short are puma560 (pose, `lm`)" in text
    assert "* false success (2): puma560" in text


def test_shares_are_rounded_down(robust: Any) -> None:
    assert robust.page.percent(1.0) == "100 %"
    assert robust.page.percent(19_999 / 20_000) == "99.995 %"
    assert robust.page.percent(0.99999999) == "99.9999 %"
