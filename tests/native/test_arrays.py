"""Arrays of any number type, layout and length give what plain ones give."""

import numpy as np
import pytest

from numpy_fk import fk as numpy_fk


@pytest.mark.parametrize("dtype", [np.float32, np.float16, np.int64, np.uint8, ">f8"])
def test_numbers_of_any_kind_are_taken(load_robot, dtype):
    arm = load_robot("strawberry")
    targets = np.array([[2, 1, 1], [1, 1, 2]], dtype=dtype)
    np.testing.assert_array_equal(arm.ik(targets).q, arm.ik(targets.astype(float)).q)
    np.testing.assert_array_equal(arm.ik(targets.tolist()).q, arm.ik(targets.astype(float)).q)


def test_layouts_of_any_kind_are_taken(load_robot):
    arm = load_robot("puma560")
    targets = arm.fk(arm.random_q(30, seed=0))
    expected = arm.ik(targets).q
    read_only = targets.copy()
    read_only.flags.writeable = False
    spread = np.zeros((60, 5, 4))[::2, :4]
    spread[...] = targets
    unaligned = np.frombuffer(b"x" + targets.tobytes(), np.float64, offset=1).reshape(30, 4, 4)
    for layout in (read_only, np.asfortranarray(targets), spread, unaligned, targets[::-1][::-1]):
        np.testing.assert_array_equal(arm.ik(layout).q, expected)
        np.testing.assert_array_equal(arm.ik(layout[7]).q, arm.ik(targets[7]).q)
    q_unaligned = np.frombuffer(b"x" + bytes(48), np.float64, offset=1)
    np.testing.assert_array_equal(arm.fk(q_unaligned), arm.fk(np.zeros(6)))
    q = arm.random_q(30, seed=1)
    for function in (arm.fk, arm.jacobian, arm.fk_links):
        np.testing.assert_array_equal(function(np.asfortranarray(q)), function(q))
        np.testing.assert_array_equal(function(q[3].tolist()), function(q)[3])
        np.testing.assert_array_equal(function(q.reshape(5, 6, 6))[1, 2], function(q)[8])


@pytest.mark.parametrize("name", ["redundant7", "strawberry", "panda"])
def test_with_many_rows_kinematics_give_the_same(load_robot, name):
    arm = load_robot(name)
    q = arm.random_q(1000, seed=8)
    np.testing.assert_allclose(arm.fk(q), numpy_fk(name, q), atol=1e-12)
    np.testing.assert_array_equal(arm.fk_links(q)[:, -1].shape, (1000, 4, 4))
    np.testing.assert_allclose(arm.fk_links(q)[:, -1], arm.fk(q), atol=1e-12)
    assert len(arm.link_names) == arm.fk_links(q).shape[1]
    np.testing.assert_array_equal(arm.jacobian(q)[17], arm.jacobian(q[17]))
    step = 1e-6
    for joint in range(arm.dof):
        change = np.zeros(arm.dof)
        change[joint] = step
        moved = (arm.fk(q[:20] + change) - arm.fk(q[:20] - change)) / (2 * step)
        np.testing.assert_allclose(arm.jacobian(q[:20])[:, :3, joint], moved[:, :3, 3], atol=1e-8)
