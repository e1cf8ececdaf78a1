"""Modules under their former names hold what they held."""

import importlib

import pytest

FORMER = {
    "closed_form": "arms",
    "euler": "rotations",
    "gain_file": "solvers.gain_file",
    "goals": "tuning.goals",
    "tune": "tuning",
}
# Functions for ZYZ angles alone; tests/test_rotations.py compares them with the general ones.
OF_ITS_OWN = {"ZyzAngles", "pose_from_zyz", "rotation_from_zyz", "zyz_from_pose"}


@pytest.mark.parametrize(("former", "present"), FORMER.items())
def test_former_modules_hold_the_present_ones_names(former: str, present: str) -> None:
    old = importlib.import_module(f"agrik_fast.{former}")
    new = importlib.import_module(f"agrik_fast.{present}")
    assert old.__all__
    for name in set(old.__all__) - OF_ITS_OWN:
        assert getattr(old, name) is getattr(new, name)
    for name in OF_ITS_OWN & set(old.__all__):
        assert callable(getattr(old, name))
