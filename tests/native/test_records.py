"""Records of answers: rows, tables, pickles, and what they say of themselves."""

from __future__ import annotations

import copy
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

import agrik_fast as ik

ARM = ik.Robot.load("ur5")
POSES = ARM.fk(ARM.random_q(24, seed=5)).reshape(4, 6, 4, 4)
SOLVED = ARM.ik(POSES)
BRANCHED = ik.Robot.load("puma560")
ALL = BRANCHED.ik_all(BRANCHED.fk(BRANCHED.random_q(5, seed=5)))


def same(a: object, b: object) -> None:
    left, right = a.to_dict(), b.to_dict()  # type: ignore[attr-defined]
    assert left.keys() == right.keys()
    for name, array in left.items():
        assert array.dtype == right[name].dtype
        np.testing.assert_array_equal(array, right[name])


@pytest.mark.parametrize("record", [SOLVED, ALL, ARM.ik(POSES[0, 0]), ALL[2]])
def test_records_are_pickled_and_copied(record: object) -> None:
    same(pickle.loads(pickle.dumps(record)), record)
    same(copy.copy(record), record)
    same(copy.deepcopy(record), record)


def test_rows_are_those_of_an_array() -> None:
    assert len(SOLVED) == 4
    assert SOLVED[1].status.shape == (6,)
    assert SOLVED[1, 2].q.shape == (6,)
    mask = SOLVED.position_error < np.median(SOLVED.position_error)
    for key in (2, -1, (1, 3), slice(1, 3), [3, 0], mask, (slice(None), 0), ..., None):
        picked = SOLVED[key]
        np.testing.assert_array_equal(picked.q, SOLVED.q[key])
        np.testing.assert_array_equal(picked.iterations, SOLVED.iterations[key])
        np.testing.assert_array_equal(picked.success, SOLVED.success[key])
    assert [row.status.shape for row in SOLVED] == [(6,)] * 4
    assert len(ALL) == 5
    np.testing.assert_array_equal(ALL[3].q, ALL.q[3])
    with pytest.raises(IndexError):
        SOLVED[4]
    with pytest.raises(TypeError, match="single target"):
        len(ARM.ik(POSES[0, 0]))


def test_truth_is_of_one_target() -> None:
    assert ARM.ik(POSES[0, 0])
    assert not ARM.ik([9.0, 0, 0])
    with pytest.raises(ValueError, match=r"24 targets is ambiguous: use result\.success\.all"):
        bool(SOLVED)


def test_tables_have_a_row_a_target() -> None:
    arrow, pandas = SOLVED.to_arrow(), SOLVED.to_pandas()
    assert arrow.num_rows == len(pandas) == 24
    names = [*(f"q_{k}" for k in range(6)), "status", "success", "position_error"]
    assert set(names) <= set(arrow.column_names)
    assert list(pandas.columns) == arrow.column_names
    np.testing.assert_array_equal(pandas["q_3"], SOLVED.q.reshape(-1, 6)[:, 3])
    assert set(arrow["status"].to_pylist()) == {"converged"}
    branches = ALL.to_pandas()
    assert len(branches) == 40
    np.testing.assert_array_equal(branches["valid"], ALL.valid.reshape(-1))
    np.testing.assert_array_equal(branches["branch"], np.tile(np.arange(8), 5))
    assert len(ARM.ik(POSES[0, 0]).to_arrow()) == 1


def test_what_they_say_of_themselves() -> None:
    assert repr(SOLVED) == "IkResult(24 targets: 24 converged)"
    alone = repr(ARM.ik(POSES[0, 0]))
    assert alone.startswith("IkResult(1 target: 1 converged, q=[")
    assert "position_error=" in alone
    table = SOLVED._repr_html_()
    assert table.count("<tr>") == 12
    assert "and 14 more" in table
    assert "<table>" in ALL._repr_html_()


def one(index: int) -> ik.IkResult:
    return ARM.ik(POSES[0, index])


def test_process_pools_hand_them_back() -> None:
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        for index, found in enumerate(pool.map(one, range(3))):
            same(found, one(index))


def test_a_solver_hands_out_copies_and_can_be_pickled() -> None:
    solver = ARM.solver(task="pose", seed=3, orientation_tolerance=1e-4)
    answers = []
    for pose in POSES[0, :4]:
        assert solver.solve(pose)
        answers.append(solver.q)
    np.testing.assert_allclose(ARM.fk(np.array(answers)), POSES[0, :4], rtol=0, atol=1e-3)
    again = pickle.loads(pickle.dumps(solver))
    again.solve(POSES[0, 3])
    np.testing.assert_array_equal(again.q, answers[3])


def test_arrays_that_do_not_belong_together_are_refused() -> None:
    from agrik_fast import _native

    fields = SOLVED.to_dict()
    fields.pop("success")
    with pytest.raises(ik.ArgumentError):
        _native.ik_result(**{**fields, "q": fields["q"][:2]})
    with pytest.raises(ik.ArgumentError):
        _native.ik_result(**{**fields, "iterations": fields["iterations"].astype(float)})
