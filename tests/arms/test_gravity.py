"""Holding torques of any chain: the tomato arm's formulas, and the energy's derivative."""

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import ArgumentError, UnknownNameError
from agrik_fast.arms import Load, PointMass, gravity_torques, holding_torques
from agrik_fast.papers import tomato as paper


def test_the_tomato_arm_holds_what_its_formulas_say() -> None:
    arm, load = ik.Robot.load("tomato"), Load()
    masses = [
        PointMass(link="phi1_link", mass=load.link1, position=(0.08, 0, 0)),
        PointMass(link="phi2_link", mass=load.link2, position=(0.08, 0, 0)),
        PointMass(link="phi2_link", mass=load.motor),
        PointMass(link="tool", mass=load.payload),
    ]
    for phi1, phi2, phi3 in ((0.0, 0.0, 0.0), (0.7, -1.1, 0.4), (2.0, -0.3, -0.9)):
        held = gravity_torques(arm, [phi1, phi2, phi3], masses)
        wanted = holding_torques(phi1=phi1, phi2=phi2)
        np.testing.assert_allclose(held, [wanted.shoulder, wanted.elbow, 0.0], atol=1e-15)


@pytest.mark.parametrize("name", ["strawberry", "cucumber", "hydrolek", "redundant7", "panda"])
def test_torques_are_the_derivative_of_the_energy(name: str) -> None:
    arm = ik.Robot.load(name)
    masses = [
        PointMass(link=link, mass=0.5 + k, position=(0.1, -0.05 * k, 0.02))
        for k, link in enumerate(arm.link_names)
    ]
    up = np.array([0.3, -0.2, 1.0])

    def energy(q: np.ndarray) -> float:
        frames = arm.fk_links(q)
        points = [
            frame[:3, :3] @ each.position + frame[:3, 3]
            for frame, each in zip(frames, masses, strict=True)
        ]
        heights = np.array(points) @ (up / np.linalg.norm(up))
        return float(9.80665 * sum(each.mass * h for each, h in zip(masses, heights, strict=True)))

    q, step = arm.random_q(seed=3), 1e-5
    slopes = [(energy(q + step * e) - energy(q - step * e)) / (2 * step) for e in np.eye(arm.dof)]
    np.testing.assert_allclose(gravity_torques(arm, q, masses, up=up), slopes, atol=1e-6)
    many = arm.random_q((2, 3), seed=4)
    each = [gravity_torques(arm, one, masses) for one in many.reshape(-1, arm.dof)]
    held = gravity_torques(arm, many, masses)
    np.testing.assert_allclose(held.reshape(-1, arm.dof), each, atol=1e-12)


def test_more_links_need_more_torque_only_if_they_are_longer_or_carry_motors() -> None:
    rows = paper.torques_by_links()
    assert [row.links for row in rows] == list(range(1, 9))
    two = rows[1]
    assert two.longer == pytest.approx(holding_torques().shoulder, rel=1e-12)
    assert two.divided == pytest.approx(two.longer, rel=1e-12)
    longer = np.diff([row.longer for row in rows], 2)
    np.testing.assert_allclose(longer, longer[0], rtol=1e-9)  # a square law
    assert longer[0] > 0
    np.testing.assert_allclose(np.diff([row.divided for row in rows]), 0.0675, atol=1e-4)
    assert {round(row.divided_without_motors, 9) for row in rows} == {0.257326496}


def test_bad_arguments() -> None:
    arm = ik.Robot.load("tomato")
    load = [PointMass(link="tool", mass=0.1)]
    for call in (
        lambda: PointMass(link="tool", mass=-1.0),
        lambda: PointMass(link="tool", mass=1.0, position=(0, np.nan, 0)),
        lambda: gravity_torques(arm, [0.0, 0.0], load),
        lambda: gravity_torques(arm, [0.0] * 3, [0.1]),
        lambda: gravity_torques(arm, [0.0] * 3, load, gravity=-1.0),
        lambda: gravity_torques(arm, [0.0] * 3, load, up=(0, 0, 0)),
    ):
        with pytest.raises(ArgumentError):
            call()
    with pytest.raises(UnknownNameError, match="tool"):
        gravity_torques(arm, [0.0] * 3, [PointMass(link="toll", mass=0.1)])


def test_joints_that_follow_others_are_refused() -> None:
    urdf = """<robot name="f"><link name="a"/><link name="b"/><link name="c"/>
    <joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/></joint>
    <joint name="k" type="continuous"><parent link="b"/><child link="c"/><origin xyz="1 0 0"/>
    <axis xyz="0 1 0"/><mimic joint="j"/></joint></robot>"""
    with pytest.raises(ArgumentError, match="follow others"):
        gravity_torques(ik.Robot.from_urdf(urdf), [0.1], [PointMass(link="c", mass=1.0)])
