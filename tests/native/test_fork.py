"""A forked child may call a batch, whatever its parent did before."""

import subprocess
import sys

# In a process of its own: a hang must not take the test run with it, and newer Pythons
# warn about any fork with threads around.
SCRIPT = """
import os, sys, warnings
import numpy as np
import agrik_fast as ik

warnings.simplefilter("ignore")
arm = ik.Robot.load("puma560")
targets = arm.fk(arm.random_q(3000, seed=1))
if sys.argv[1] == "parent first":
    expected = arm.ik(targets, threads=2).q

def child():
    q = arm.ik(targets, threads=2).q
    again = arm.ik(targets, threads=3).q
    return np.array_equal(q, again)

def fork(body):
    pid = os.fork()
    if pid == 0:
        os._exit(0 if body() else 9)
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])

codes = [fork(child), fork(lambda: child() and fork(child) == 0)]
after = arm.ik(targets, threads=2).q
if sys.argv[1] == "parent first":
    codes.append(int(not np.array_equal(expected, after)))
print(codes)
sys.exit(any(codes))
"""


def run(order):
    return subprocess.run(
        [sys.executable, "-c", SCRIPT, order],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def test_children_of_a_parent_that_has_a_pool():
    done = run("parent first")
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout == "[0, 0, 0]\n"


def test_children_of_a_parent_that_has_none():
    done = run("child first")
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout == "[0, 0]\n"
