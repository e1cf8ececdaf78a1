"""Memory of large calls, and inputs that change while a call runs."""

import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import solvers

# The peak of a process never falls, so each measurement has one of its own.
SCRIPT = """
import resource, sys
import numpy as np
import agrik_fast as ik

def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024

FIELDS = "q success status position_error orientation_error iterations restarts".split()
arm = ik.Robot.load(sys.argv[1])
few = arm.fk(arm.random_q(1000, seed=1))
if sys.argv[2] == "position":
    few = np.ascontiguousarray(few[:, :3, 3])
arm.ik(few, threads=2).q
baseline = peak()
targets = np.tile(few, (1000,) + (1,) * (few.ndim - 1))
result = arm.ik(targets, threads=2)
arrays = [getattr(result, field) for field in FIELDS]
used = peak() - baseline
assert result.success.all()
print(used, targets.nbytes + sum(array.nbytes for array in arrays))
"""


@pytest.mark.parametrize("task", ["position", "pose"])
def test_a_million_targets_take_less_than_three_times_their_data(task):
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, "puma560", task],
        capture_output=True,
        text=True,
        timeout=110,
        check=True,
    )
    used, data = map(int, done.stdout.split())
    assert used < 3 * data


@pytest.mark.parametrize("leading", [(20_000,), (100, 200)])
def test_writing_to_the_inputs_during_a_call_changes_nothing(leading):
    # Out of the elbow's range, so that the call lasts long enough to be overtaken.
    arm = ik.Robot.from_dh([[1, 0, 0, 0], [1, 0, 0, 0]], limits=[[-3, 3], [1, 2]])
    rng = np.random.Generator(np.random.PCG64(1))
    targets = rng.uniform([1.85, -0.1, 0], [1.95, 0.1, 0], (*leading, 3))
    q0 = arm.random_q(leading, seed=1)
    solver = solvers.LevenbergMarquardt(max_restarts=50)
    expected = arm.ik(targets.copy(), q0=q0.copy(), solver=solver, threads=2)
    assert not expected.success.any()

    answers = []
    entered = threading.Event()

    def work():
        entered.set()
        answers.append(arm.ik(targets, q0=q0, solver=solver, threads=2))

    thread = threading.Thread(target=work)
    thread.start()
    entered.wait()
    # The inputs are copied in the first milliseconds.
    time.sleep(0.2)
    while thread.is_alive():
        targets[...] = np.nan
        q0[...] = np.inf
        time.sleep(0.001)
    thread.join()
    for field in ("q", "status", "position_error", "iterations", "restarts"):
        np.testing.assert_array_equal(getattr(answers[0], field), getattr(expected, field))


def test_results_outlive_what_they_came_from():
    arm = ik.Robot.load("tomato")
    targets = arm.fk(arm.random_q(5000, seed=1))[:, :3, 3]
    result = arm.ik(targets)
    q, expected = result.q, result.q.copy()
    del result, arm
    arrays = [np.zeros(5000) for _ in range(50)]
    np.testing.assert_array_equal(q, expected)
    assert len(arrays) == 50
