"""A sample of the paths that `make motion-full` puts before a second judge."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

import path_checker
import paths_full
import proofs_full
from agrik_fast import Robot


@pytest.mark.parametrize("seed", [501, 503])
def test_every_path_is_accepted(seed: int) -> None:
    _, kinds, faults = paths_full.of_seed(seed)
    assert faults == []
    assert Counter(arm for arm, _ in kinds)["panda"] >= 4
    assert len({arm for arm, _ in kinds}) >= 2


@pytest.mark.parametrize("name", proofs_full.ARMS)
def test_no_body_moves_farther_than_its_levers_say(name: str) -> None:
    done, wrong, largest = proofs_full.displacements(name, 5000, seed=1)
    assert done >= 5000
    assert wrong == 0
    assert largest > 0.3


@pytest.mark.parametrize("name", proofs_full.SCENES)
def test_what_is_proven_is_true_at_samples(name: str) -> None:
    outcomes: Counter[str] = Counter()
    for outcome, _, fault in proofs_full.judged(name, 1500, seed=100):
        assert fault is None
        outcomes[outcome] += 1
    assert outcomes["SAFE"] >= 5
    assert outcomes["HIT"] >= 5


def test_the_judge_finds_what_is_wrong() -> None:
    """A path that is bent into a thing, and one that claims to keep more than it does."""
    one = next(paths_full.into_fruits(501))
    assert paths_full.fault(one) is None

    def least(path: np.ndarray) -> float:
        judged = path_checker.judge(
            "cucumber", path, one.scene, one.arm.self_pairs.asked, one.aim, near=0.05
        )
        return judged.least

    rows = one.path.path
    # Nothing is left of the touch zone's exemption on a way through the row.
    beyond = rows[-1].copy()
    beyond[0] += 0.4 if rows[-1][0] < 0 else -0.4
    assert least(rows) >= one.path.certified
    assert least(np.stack([rows[-1], beyond])) < 0.0
    far = Robot.load("cucumber").upper + 0.1
    judged = path_checker.judge("cucumber", np.stack([rows[0], far]), one.scene, [], near=0.0)
    assert not judged.within_limits
