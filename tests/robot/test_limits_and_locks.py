"""Other limits, locked joints, chains between any links, bases and robots of each row."""

import pickle

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import Status, _native
from agrik_fast._names import solver_names
from agrik_fast.collision import Scene
from agrik_fast.errors import ArgumentError, UnknownNameError

TREE = """<robot name="tree">
  <link name="trunk"/><link name="l1"/><link name="l2"/><link name="lhand"/>
  <link name="r1"/><link name="r2"/><link name="rhand"/>
  {joints}
</robot>"""


def joint(name, parent, child, xyz, axis, rpy="0 0 0", kind="revolute"):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>'
        '<limit lower="-2" upper="1.5" effort="1" velocity="1"/></joint>'
    )


@pytest.fixture(scope="module")
def tree():
    joints = [
        joint("a1", "trunk", "l1", "0 0.2 0.5", "0 0 1", "0.3 0 0"),
        joint("a2", "l1", "l2", "0.3 0 0", "0 1 0", "0 0.2 0"),
        joint("a3", "l2", "lhand", "0.3 0.1 0", "1 0 0", kind="prismatic"),
        joint("b1", "trunk", "r1", "0 -0.2 0.5", "0 0 1", "0 0 0.5"),
        joint("b2", "r1", "r2", "0.3 0 0", "0 1 0"),
        joint("b3", "r2", "rhand", "0.25 0 0", "0 0.6 0.8"),
    ]
    return TREE.format(joints="".join(joints))


def test_a_chain_goes_from_any_link_to_any_link(tree):
    left, right = (ik.Robot.from_urdf(tree, "trunk", hand) for hand in ("lhand", "rhand"))
    both = ik.Robot.from_urdf(tree, "lhand", "rhand")
    assert both.joint_names == ("a3", "a2", "a1", "b1", "b2", "b3")
    q = both.random_q(20, seed=1)
    there, here = left.fk(q[:, 2::-1]), right.fk(q[:, 3:])
    np.testing.assert_allclose(both.fk(q), np.linalg.inv(there) @ here, atol=1e-12)
    np.testing.assert_array_equal(both.lower, [-2] * 6)
    back = ik.Robot.from_urdf(tree, "rhand", "trunk")
    np.testing.assert_allclose(back.fk(q[:, :2:-1]), np.linalg.inv(here), atol=1e-12)
    assert back.link_names[:-1] == ("r2", "r1", "trunk")
    found = both.ik(both.fk(q)[:, :3, 3])
    assert found.success.all()
    again = pickle.loads(pickle.dumps(both))
    assert np.array_equal(again.fk(q), both.fk(q))


def test_locked_joints_stand_still():
    arm = ik.Robot.load("panda")
    q = arm.random_q(20, seed=1)
    q[:, 2] = 0.3
    six = arm.lock({"panda_joint3": 0.3})
    assert six.dof == 6 and "panda_joint3" not in six.joint_names
    np.testing.assert_allclose(six.fk(np.delete(q, 2, axis=1)), arm.fk(q), atol=1e-12)
    assert six.ik(arm.fk(q)).success.all()
    assert six.lock({"panda_joint1": 0.1, "panda_joint7": 0.2}).dof == 4
    assert pickle.loads(pickle.dumps(six)) == six
    assert six.fingerprint != arm.fingerprint
    assert len(six.bodies) == len(arm.bodies)
    dh = ik.Robot.load("puma560")
    name = dh.joint_names[1]
    five = dh.lock({name: -0.4})
    p = dh.random_q(10, seed=2)
    p[:, 1] = -0.4
    np.testing.assert_allclose(five.fk(np.delete(p, 1, axis=1)), dh.fk(p), atol=1e-12)


def test_limits_are_replaced_by_name_or_as_a_table():
    arm = ik.Robot.load("ur5")
    tight = arm.with_limits({"elbow": (-1.0, 1.0)})
    assert (tight.lower[2], tight.upper[2]) == (-1.0, 1.0)
    assert tight.lower[0] == arm.lower[0]
    assert tight.dh is None or tight.dh[2].upper == 1.0
    result = tight.ik(tight.fk(tight.random_q(50, seed=1)))
    assert result.success.all() and (abs(result.q[:, 2]) <= 1.0).all()
    table = np.full((6, 2), np.nan)
    table[4] = [-0.5, 0.7]
    assert arm.with_limits(table).upper[4] == 0.7
    assert arm.with_limits(table).lower[0] == arm.lower[0]
    assert pickle.loads(pickle.dumps(tight)) == tight
    free = arm.with_limits({"elbow": (-np.inf, np.inf)})
    assert free.joint_types[2] == "continuous"


def test_limits_of_a_call_and_of_each_row():
    arm = ik.Robot.load("ur5")
    q = arm.random_q(12, seed=3)
    poses = arm.fk(q)
    around = np.stack([q - 0.2, q + 0.2], axis=-1)
    result = arm.ik(poses, limits=around)
    assert result.success.all()
    assert ((result.q >= around[..., 0]) & (result.q <= around[..., 1])).all()
    whole = arm.ik(poses, limits=[[-3, 3]] * 6)
    assert (abs(whole.q) <= 3).all()
    around[5, 2] = [1.0, -1.0]
    mixed = arm.ik(poses, limits=around)
    assert mixed.status[5] == Status.BAD_INPUT
    assert np.delete(mixed.success, 5).all()


def test_bases_of_each_row_and_several_robots():
    arm = ik.Robot.load("ur5")
    q = arm.random_q(5, seed=4)
    bases = ik.Robot.load("puma560").fk(ik.Robot.load("puma560").random_q(5, seed=5))
    poses = np.stack([arm.with_base(b).fk(x) for b, x in zip(bases, q, strict=True)])
    result = arm.ik(poses, base=bases)
    assert result.success.all()
    for base, pose, found in zip(bases, poses, result.q, strict=True):
        np.testing.assert_allclose(arm.with_base(base).fk(found), pose, atol=5e-6)
    assert arm.ik(poses[:, :3, 3], base=bases).success.all()
    arms = [ik.Robot.load(name) for name in ("ur3e", "ur5e", "ur10e")]
    targets = np.stack([one.fk(one.random_q(4, seed=1)) for one in arms])
    many = ik.Robot.ik_many(arms, targets)
    assert many.q.shape == (3, 4, 6) and many.success.all()
    for one, goals, row in zip(arms, targets, many.q, strict=True):
        assert np.array_equal(row, one.ik(goals).q)


def test_wrong_limits_and_locks_are_named():
    arm = ik.Robot.load("panda")
    with pytest.raises(ArgumentError, match=r"joint3.*within the limits"):
        arm.lock({"panda_joint3": 9.0})
    with pytest.raises(UnknownNameError, match="joint"):
        arm.lock({"joint9": 0.0})
    with pytest.raises(ArgumentError, match="at least one"):
        arm.lock(dict.fromkeys(arm.joint_names, -0.5) | {"panda_joint6": 1.0})
    with pytest.raises(ArgumentError, match=r"joint1.*lower <= upper"):
        arm.with_limits({"panda_joint1": (1.0, -1.0)})
    with pytest.raises(UnknownNameError, match="joint"):
        arm.with_limits({"elbow": (0, 1)})
    with pytest.raises(ArgumentError, match="limits"):
        arm.with_limits([[0, 1]] * 3)
    pose = arm.fk(arm.random_q(seed=1))
    with pytest.raises(ArgumentError, match="limits"):
        arm.ik(pose, limits=[0, 1])
    with pytest.raises(ArgumentError, match="base"):
        arm.ik(pose, base=np.zeros((4, 4)))
    with pytest.raises(ArgumentError, match="robots"):
        ik.Robot.ik_many([arm, ik.Robot.load("ur5")], pose)


@pytest.mark.parametrize("name", ["ur5", "panda", "iiwa14", "strawberry"])
def test_limits_of_each_row_are_kept_whatever_the_other_rows(name):
    arm = ik.Robot.load(name)
    q = arm.random_q(300, seed=3)
    poses = arm.fk(q) if arm.dof >= 6 else arm.fk(q)[:, :3, 3]
    rng = np.random.default_rng(1)
    below, above = rng.uniform(0.05, 1.0, (2, *q.shape))
    limits = np.stack([q - below, q + above], axis=-1)
    result = arm.ik(poses, limits=limits)
    assert result.success.mean() >= 0.99
    assert (result.q >= limits[..., 0]).all() and (result.q <= limits[..., 1]).all()
    # A row does not depend on the others, nor on threads.
    for row in (0, 150, 299):
        one = slice(row, row + 1)
        alone = arm.ik(poses[one], limits=limits[one], first_index=row)
        assert np.array_equal(alone.q, result.q[one])
    some = arm.ik(poses[100:], limits=limits[100:], first_index=100, threads=1)
    assert np.array_equal(some.q, result.q[100:])
    from_there = arm.ik(poses, q0=q, limits=limits)
    assert from_there.success.all() and (from_there.iterations == 0).all()
    assert np.array_equal(from_there.q, q)


def test_limits_of_each_row_say_what_cannot_be():
    arm = ik.Robot.load("panda")
    q = arm.random_q(6, seed=3)
    poses = arm.fk(q)
    limits = np.stack([np.full_like(q, np.nan), np.full_like(q, np.nan)], axis=-1)
    # NaN: the robot's own.
    assert arm.ik(poses, limits=limits).success.all()
    limits[1, 2] = [0.5, -0.5]
    limits[2] = np.stack([q[2] + 0.3, q[2] + 0.4], axis=-1)
    poses[3, :3, 3] = [9, 0, 0]
    result = arm.ik(poses, limits=limits, solver=ik.solvers.LevenbergMarquardt(max_restarts=20))
    assert result.status[1] == Status.BAD_INPUT
    assert result.status[2] == Status.NOT_FOUND
    assert ((result.q[2] >= limits[2, :, 0]) & (result.q[2] <= limits[2, :, 1])).all()
    assert result.status[3] == Status.OUT_OF_REACH
    assert result.success[[0, 4, 5]].all()
    wide = np.stack([q - 4.0, q + 4.0], axis=-1)
    beyond = arm.ik(poses[:2], limits=wide[:2])
    assert beyond.success.all()


@pytest.mark.parametrize("solver", [*_native.limited_solver_names(), "auto", "ik-pid"])
def test_limits_of_each_row_beside_other_wishes(solver):
    arm = ik.Robot.load("ur5")
    q = arm.random_q(8, seed=3)
    limits = np.stack([q - 0.5, q + 0.5], axis=-1)
    for wish in ({}, {"second_aim": "middle"}, {"q0": q, "nearest": True}):
        result = arm.ik(arm.fk(q), limits=limits, solver=solver, **wish)
        # These go on from one start, or by short steps.
        assert result.success.sum() >= (4 if solver in ("transpose", "ik-pid") else 8)
        assert ((result.q >= limits[..., 0]) & (result.q <= limits[..., 1])).all()


def test_the_core_tells_which_solvers_take_limits_of_each_row():
    arm = ik.Robot.load("ur5")
    q = arm.random_q(2, seed=3)
    limits = np.stack([q - 0.5, q + 0.5], axis=-1)
    taking = _native.limited_solver_names()
    assert set(taking) == {"transpose", "pinv", "dls", "lm", "pinv-closed"}
    for name in taking:
        assert arm._chain.ik(arm.fk(q), solver=name, limits=limits).success.all()
    for name in set(solver_names()) - set(taking):
        task = "pose" if name == "closed_form" else "position"
        with pytest.raises(ArgumentError, match="limits"):
            arm._chain.ik(arm.fk(q), task, name, limits=limits)
    # Wishes that move answers on are none that the core has with them.
    with pytest.raises(ArgumentError, match="limits"):
        arm._chain.ik(arm.fk(q), solver="lm", limits=limits, second_aim="middle")


def test_a_scene_without_objects_is_a_wish_beside_limits_of_each_row():
    arm = ik.Robot.load("panda")
    q = arm.random_q(4, seed=3)
    poses = arm.fk(q)
    limits = np.stack([np.maximum(arm.lower, q - 0.6), np.minimum(arm.upper, q + 0.6)], axis=-1)
    wish = {"scene": Scene(), "prefer": "clearance"}
    result = arm.ik(poses, limits=limits, **wish)
    assert result.success.any()
    for row, pair in enumerate(limits):
        alone = arm.with_limits(pair).ik(poses[row : row + 1], first_index=row, **wish)
        assert np.array_equal(result.q[row], alone.q[0])
        assert result.clearance[row] == alone.clearance[0]


@pytest.mark.parametrize("name", ["panda", "iiwa14", "redundant7"])
@pytest.mark.parametrize("held", [False, True])
def test_answers_in_narrow_rows_keep_off_limits(name, held):
    arm = ik.Robot.load(name)
    q = arm.random_q(300, seed=3)
    below, above = np.random.default_rng(1).uniform(0.0, 0.05, (2, *q.shape))
    limits = np.stack([np.maximum(arm.lower, q - below), np.minimum(arm.upper, q + above)], -1)
    if held:
        limits[:, 0] = q[:, :1]
    result = arm.ik(arm.fk(q), limits=limits)
    assert result.success.all()
    at = (result.q <= limits[..., 0]) | (result.q >= limits[..., 1])
    at = at[:, held:].any(1)
    # Left at their first answers, or sought from starts at these limits: 4 to 6 %, held 0.7 to 2.
    assert at.mean() <= (0.004 if held else 0.03)


def test_a_joint_that_turns_freely_stays_between_limits_of_its_row():
    arm = ik.Robot.load("ur5").with_limits({"wrist_3": (-np.inf, np.inf), "elbow": (-3.0, 3.0)})
    assert arm.joint_types[-1] == "continuous"
    q = arm.random_q(60, seed=3)
    limits = np.full((60, 6, 2), np.nan)
    limits[:30, 5] = np.stack([q[:30, 5] + 2 * np.pi - 0.5, q[:30, 5] + 2 * np.pi + 0.5], axis=-1)
    limits[30:45, 5] = [-9.0, 9.0]
    result = arm.ik(arm.fk(q), limits=limits)
    assert result.success.all()
    at = result.q[:45, 5]
    assert ((at >= limits[:45, 5, 0]) & (at <= limits[:45, 5, 1])).all()
    assert (abs(result.q[45:, 5]) <= np.pi + 1e-9).all()


@pytest.mark.parametrize(
    "bad", [(np.inf, np.inf), (-np.inf, -np.inf), (1e51, np.inf), (1e60, 2e60)]
)
@pytest.mark.parametrize("solver", ["lm", "broyden"])
def test_limits_that_no_number_keeps_are_bad_input(bad, solver):
    arm = ik.Robot.load("ur5")
    poses = arm.fk(arm.random_q(3, seed=1))
    table = np.stack([arm.lower, arm.upper], axis=1)
    rows = np.tile(table, (3, 1, 1))
    rows[1, 0] = bad
    found = arm.ik(poses, limits=rows, solver=solver)
    assert found.status[1] == Status.BAD_INPUT
    assert np.isfinite(found.q).all()
    assert found.success[[0, 2]].all() or solver == "broyden"
    with pytest.raises(ArgumentError, match="limits"):
        arm.ik(poses, limits=rows[1], solver=solver)
    with pytest.raises(ArgumentError, match="limits"):
        arm.with_limits(rows[1])


def test_an_arm_behind_a_slide_says_what_to_lock():
    arm = ik.Robot.load("cucumber")
    with pytest.raises(ArgumentError, match=r"`locked`: expected a value of the slide 'd1'"):
        arm.ik_all(arm.fk(arm.random_q(seed=1)))
