"""URDFs written by others, kinematics by others: this library against Pinocchio.

The files come from the packages `example-robot-data` and `rtb-data` as their authors
wrote them; `make oracle` installs both, and Pinocchio, in an environment of their own.
"""

from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import numpy as np
import pinocchio
import pytest

import agrik_fast as ik

CONFIGURATIONS = 200
TOLERANCE = 1e-9  # m, rad


@dataclass(frozen=True)
class Case:
    """A file of a package and the chain that is asked for."""

    package: str
    file: str
    tip: str
    dof: int
    types: str = ""
    """First letters of the joint types; revolute if not said."""

    def path(self) -> Path:
        """Return where the package has put the file."""
        for file in metadata.files(self.package) or ():
            if file.as_posix().endswith("/" + self.file):
                return Path(str(file.locate())).resolve()
        raise FileNotFoundError(f"{self.package} has no {self.file}")


CASES = {
    "panda": Case("example-robot-data", "panda_description/urdf/panda.urdf", "panda_hand_tcp", 7),
    "panda finger": Case(
        "example-robot-data", "panda_description/urdf/panda.urdf", "panda_leftfinger", 8, "rrrrrrrp"
    ),
    # Follows the other finger, whose joint is not on this chain.
    "panda mimic finger": Case(
        "example-robot-data",
        "panda_description/urdf/panda.urdf",
        "panda_rightfinger",
        8,
        "rrrrrrrp",
    ),
    "ur5": Case("example-robot-data", "ur_description/urdf/ur5_robot.urdf", "tool0", 6),
    "xarm7": Case("example-robot-data", "xarm_description/urdf/xarm7.urdf", "link_eef", 7),
    "kinova": Case(
        "example-robot-data",
        "kinova_description/robots/kinova.urdf",
        "j2s6s200_end_effector",
        6,
        "crrcrc",
    ),
    "iiwa14": Case("rtb-data", "kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf", "tool0", 7),
    "kr16": Case("rtb-data", "kuka_kr16/urdf/kr16_2.urdf", "tool0", 6),
    "kr120": Case("rtb-data", "kuka_kr120/urdf/kr120r2500pro.urdf", "tool0", 6),
    "kr210": Case("rtb-data", "kuka_kr210/urdf/kr210l150.urdf", "tool0", 6),
}


class Oracle:
    """Pinocchio's model of the same file, asked with this library's joint values."""

    def __init__(self, robot: ik.Robot, case: Case) -> None:
        self.model = pinocchio.buildModelFromUrdf(str(case.path()), mimic=True)
        self.data = self.model.createData()
        self.frame = self.model.getFrameId(case.tip)
        self.joints = [self.model.joints[self.model.getJointId(n)] for n in robot.joint_names]

    def evaluate(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the tip's pose (4, 4) and Jacobian (6, n)."""
        values = pinocchio.neutral(self.model)
        for joint, value in zip(self.joints, q, strict=True):
            # Free joints are points of the unit circle there.
            is_free = joint.nq == 2
            values[joint.idx_q : joint.idx_q + joint.nq] = (
                (np.cos(value), np.sin(value)) if is_free else value
            )
        pinocchio.framesForwardKinematics(self.model, self.data, values)
        jacobian = pinocchio.computeFrameJacobian(
            self.model, self.data, values, self.frame, pinocchio.LOCAL_WORLD_ALIGNED
        )
        columns = [joint.idx_v for joint in self.joints]
        return self.data.oMf[self.frame].homogeneous.copy(), jacobian[:, columns].copy()


@pytest.fixture(params=CASES)
def case(request: pytest.FixtureRequest) -> Case:
    return CASES[request.param]


@pytest.fixture
def robot(case: Case) -> ik.Robot:
    return ik.Robot.from_urdf(case.path(), tip_link=case.tip)


def test_joints_and_limits(case: Case, robot: ik.Robot) -> None:
    assert robot.dof == case.dof
    assert "".join(name[0] for name in robot.joint_types) == (case.types or "r" * case.dof)
    oracle = Oracle(robot, case)
    for i, joint in enumerate(oracle.joints):
        if robot.joint_types[i] == "continuous":
            assert joint.nq == 2
            assert robot.lower[i] == -np.inf
            assert robot.upper[i] == np.inf
        else:
            assert robot.lower[i] == oracle.model.lowerPositionLimit[joint.idx_q]
            assert robot.upper[i] == oracle.model.upperPositionLimit[joint.idx_q]


def test_forward_kinematics_and_jacobian(case: Case, robot: ik.Robot) -> None:
    oracle = Oracle(robot, case)
    q = robot.random_q(CONFIGURATIONS, seed=7)
    poses, jacobians = zip(*(oracle.evaluate(row) for row in q), strict=True)
    np.testing.assert_allclose(robot.fk(q), poses, rtol=0, atol=TOLERANCE)
    np.testing.assert_allclose(robot.jacobian(q), jacobians, rtol=0, atol=TOLERANCE)
    # The comparison would mean nothing if the chain did not move.
    assert np.ptp(np.asarray(poses)[:, :3, 3], axis=0).min() > 0.1


def test_solutions_stand_up_to_the_oracle(case: Case, robot: ik.Robot) -> None:
    oracle = Oracle(robot, case)
    targets = robot.fk(robot.random_q(CONFIGURATIONS, seed=8))
    result = robot.ik(targets, seed=9)
    assert result.success.mean() >= 0.99
    for target, q in zip(targets[result.success], result.q[result.success], strict=True):
        pose, _ = oracle.evaluate(q)
        np.testing.assert_allclose(pose, target, rtol=0, atol=1e-5)


def test_its_poses_are_targets() -> None:
    arm = ik.Robot.load("ur5")
    poses = arm.fk(arm.random_q(20, seed=10))
    objects = [pinocchio.SE3(pose) for pose in poses]
    wanted = arm.ik(np.array([one.homogeneous for one in objects]))
    np.testing.assert_array_equal(arm.ik(objects).q, wanted.q)
    np.testing.assert_array_equal(arm.ik(objects[0]).q, arm.ik(objects[0].homogeneous).q)
