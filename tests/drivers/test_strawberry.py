"""The strawberry rig's driver, on the board's program and a simulated plant."""

import math
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from agrik_fast.arms import StrawberryArm
from agrik_fast.drivers import (
    Arrival,
    ClearanceError,
    CommandRefusedError,
    LinkError,
    OutOfReachError,
    RigError,
    RigFaultError,
    RigStatus,
    SimulatorError,
    StrawberryRig,
    Surroundings,
)
from agrik_fast.drivers import _simulator as simulator_module
from agrik_fast.drivers._clearance import link_points
from agrik_fast.errors import ArgumentError
from rigs import moving, needs_simulator, simulator_of, strawberry

TARGET = [0.426, 0.345, -0.3316]
PLAYLESS = {f"slide{i}.play": 1.0 for i in range(3)}


def tip(rig: StrawberryRig) -> np.ndarray:
    """Return where the plant's tool point really is, m."""
    state = simulator_of(rig).state()
    axes = rig.calibration.axis
    slides = [(axis.home_mm + state[f"carriage{i}"]) / 1000 for i, axis in enumerate(axes)]
    return rig.arm.fk([*slides, math.radians(state["angle0"]), math.radians(state["angle1"])])


@needs_simulator
def test_pick_and_reset_by_remark_3() -> None:
    with strawberry() as rig:
        rig.home()
        assert rig.status().q == pytest.approx([*rig.arm.reset_pose, 0.0], abs=1.5e-3)
        run = rig.pick(target=TARGET, psi=0.5)
        order = [step.axis for step in run.steps]
        assert order == ["gripper", "s32", "s10", "s21", "theta", "beta", "psi", "s32", "gripper"]
        assert run.steps[0].target == 1.0 and run.steps[-1].target == 0.0
        assert run.steps[1].target == pytest.approx(run.q[2] - 0.03)
        assert all(a.end <= b.begin for a, b in zip(run.steps, run.steps[1:], strict=False))
        assert 4.0 < run.seconds < 6.0
        assert max(abs(step.encoder_error) for step in run.steps) <= 0.5e-3
        np.testing.assert_allclose(tip(rig), TARGET, rtol=0, atol=2.5e-3)
        assert simulator_of(rig).state()["angle2"] == pytest.approx(math.degrees(0.5), abs=0.5)
        assert rig.status().q == pytest.approx(run.q, abs=1e-3)
        back = rig.reset()
        order = [step.axis for step in back.steps]
        assert order == ["s32", "psi", "beta", "theta", "s21", "s10", "s32"]
        assert back.steps[0].target < run.q[2] - 0.0299
        assert rig.status().q == pytest.approx([*rig.arm.reset_pose, 0.0], abs=1e-3)
        status = rig.status()
        assert (status.state, status.lost_ticks, status.skips) == ("idle", 0, 0)


@needs_simulator
def test_reset_at_home_stays_there() -> None:
    with strawberry() as rig:
        rig.home()
        # Homing ends within the play, so that the slide seems to be above home.
        assert rig.status().q[2] < rig.arm.reset_pose[2]
        rig.reset()
        assert rig.status().q[:3] == pytest.approx(rig.arm.reset_pose[:3], abs=0.5e-3)


@needs_simulator
def test_play_is_compensated_when_it_is_calibrated() -> None:
    with strawberry({f"slide{i}.play": 1.0 for i in range(3)}, surroundings=None) as rig:
        rig.home()
        for q in ([0.2, 0.3, 0.15, 0, 0], [0.12, 0.2, 0.1, 0, 0], [0.13, 0.25, 0.12, 0, 0]):
            rig.move(q)
            state = simulator_of(rig).state()
            for i, axis in enumerate(rig.calibration.axis):
                assert axis.home_mm + state[f"carriage{i}"] == pytest.approx(1000 * q[i], abs=0.6)


@needs_simulator
def test_move_takes_joint_values_or_a_target() -> None:
    with strawberry() as rig:
        rig.home()
        arrivals = rig.move([0.1, 0.12, 0.08, -0.1, 0.2, 0.3])
        assert {arrival.axis for arrival in arrivals} == set(rig.joint_names)
        assert rig.status().q == pytest.approx([0.1, 0.12, 0.08, -0.1, 0.2, 0.3], abs=1e-3)
        rig.move(target=[0.2, 0.33, -0.28], method="as")
        np.testing.assert_allclose(tip(rig), [0.2, 0.33, -0.28], rtol=0, atol=2.5e-3)
        for wrong in ({}, {"q": [0.1] * 5, "target": TARGET}):
            with pytest.raises(ArgumentError, match="`q, target`: expected one of them"):
                rig.move(**wrong)


@needs_simulator
def test_follow_goes_through_every_point() -> None:
    seen: list[RigStatus] = []
    with strawberry(progress=seen.append) as rig:
        rig.home()
        path = [[0.1, 0.1, 0.07, 0, 0], [0.12, 0.15, 0.08, -0.2, 0.1], [0.1, 0.2, 0.1, 0, 0.3]]
        arrivals = rig.follow(path)
        assert len(arrivals) == 18
        assert rig.status().q[:5] == pytest.approx(path[-1], abs=1e-3)
        assert len(seen) > 50 and {status.state for status in seen} >= {"homing", "moving"}
        with pytest.raises(ArgumentError, match=r"`path`: expected shape \(n, 5\) or \(n, 6\)"):
            rig.follow([[0.1, 0.1]])
        before = rig.link.report().position
        with pytest.raises(ArgumentError, match=r"`s21`: expected 80.00 to 920.00 mm, got 999.00"):
            rig.follow([path[0], [0.1, 0.999, 0.07, 0, 0]])
        assert rig.link.report().position == before


# ---- what is refused -------------------------------------------------------------------------


@needs_simulator
def test_beyond_soft_limits() -> None:
    with strawberry(surroundings=None) as rig:
        rig.home()
        for q, message in (
            ([0.7, 0.1, 0.07, 0, 0], "`s10`: expected 75.00 to 660.00 mm, got 700.00 mm"),
            ([0.1, 0.1, 0.07, 1.0, 0], "`theta`: expected -58.00 to 52.00 degrees, got 57.30"),
            ([0.1, 0.1, 0.07, 0, -0.1], "`beta`: expected 0.00 to 73.00 degrees, got -5.73"),
            ([0.1, 0.1, 0.07, 0, 0, 1.6], "`psi`: expected -90.00 to 90.00 degrees, got 91.67"),
            ([0.1, 0.1, math.nan, 0, 0], "`q`: expected finite numbers, m and rad"),
            ([0.1, 0.1], r"`q`: expected shape \(5,\) or \(6,\), m and rad, got shape \(2,\)"),
            ("home", "`q`: expected an array of numbers"),
        ):
            with pytest.raises(ArgumentError, match=message):
                rig.move(q)  # type: ignore[arg-type]
        # The board has limits of its own, should a program get past these.
        refused = r"a move of s10 to 661.9 mm: out of limits"
        with pytest.raises(CommandRefusedError, match=refused), rig._moving():
            rig._slide({0: 0.6619})
        assert rig.status().state == "idle"


@needs_simulator
def test_out_of_reach() -> None:
    with strawberry() as rig:
        rig.home()
        message = r"the target \(426.0, 1200.0, -331.6\) mm is out of reach: slide s10 lacks 324.1"
        with pytest.raises(OutOfReachError, match=message):
            rig.pick(target=[0.426, 1.2, -0.3316])
        assert rig.status().q[0] == pytest.approx(0.075, abs=1.5e-3)


@needs_simulator
def test_not_homed() -> None:
    with strawberry() as rig:
        for motion in (rig.reset, lambda: rig.pick(target=TARGET), lambda: rig.move([0.1] * 5)):
            with pytest.raises((RigError, ArgumentError)):
                motion()
        with pytest.raises(RigError, match="is not homed: `home` before `pick`"):
            rig.pick(target=TARGET)
        with pytest.raises(CommandRefusedError, match="not homed"), rig._moving():
            rig._slide({0: 0.1})
        assert np.isnan(rig.status().q[:3]).all() and not rig.status().homed


def test_not_connected() -> None:
    rig = StrawberryRig("loop://")
    for use in (rig.home, rig.stop, rig.status, rig.clear):
        with pytest.raises(RigError, match="the strawberry rig is not connected: call connect"):
            use()
    rig.close()


def test_no_firmware_and_no_compiler(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("AGRIK_FIRMWARE", str(tmp_path))
    with pytest.raises(SimulatorError, match=r"needs a checkout, but .* holds no firmware"):
        StrawberryRig().connect()
    (tmp_path / "messages.toml").write_text("")
    monkeypatch.setattr(simulator_module.shutil, "which", lambda name: None)
    with pytest.raises(SimulatorError, match="avr-gcc, pkg-config missing; `make firmware` says"):
        StrawberryRig().connect()


# ---- clearance -------------------------------------------------------------------------------


@needs_simulator
def test_ways_through_the_plant_are_refused_with_the_pair() -> None:
    far = [0.580, 0.310, -0.3779]
    with strawberry() as rig:
        rig.home()
        before = rig.link.report().position
        message = r"gripper and plant would touch \(\d+.\d mm deep\) on the step 4 of the way out"
        with pytest.raises(ClearanceError, match=message) as caught:
            rig.pick(target=far, h_extra=0.03)
        assert (caught.value.part, caught.value.obstacle) == ("gripper", "plant")
        with pytest.raises(ClearanceError, match="gripper and plant would touch"):
            rig.move(target=[0.5, 0.3675, -0.35])
        assert rig.link.report().position == before
        # By itself the driver goes as high as it has to.
        run = rig.pick(target=far)
        assert 0.03 < run.h_extra <= 0.1
        np.testing.assert_allclose(tip(rig), far, rtol=0, atol=2.5e-3)
        with pytest.raises(ClearanceError, match=r"on the step \d of the way back"):
            rig.reset(h_extra=0.0)
        rig.reset()


def test_bed_is_an_obstacle() -> None:
    arm = StrawberryArm()
    rig = StrawberryRig("loop://", surroundings=Surroundings(plant_radius=0.001, bed_top=-0.38))
    with pytest.raises(ClearanceError, match="gripper and bed would touch"):
        rig.check_ways(arm.reset_pose, [0.2, 0.3, 0.251, 0, 0], 0.03)
    rig.check_ways(arm.reset_pose, [0.2, 0.3, 0.15, 0, 0], 0.03)


def test_depths_against_many_points() -> None:
    arm, around = StrawberryArm(), Surroundings()
    random = np.random.default_rng(0)
    q = random.uniform(arm.lower, arm.upper, (300, 5))
    points = link_points(arm, q)
    np.testing.assert_allclose(points[:, 3], arm.fk(q))
    lengths = np.linalg.norm(np.diff(points, axis=1), axis=-1)
    np.testing.assert_allclose(lengths[:, 1:], [[0.102, 0.06]] * 300)
    np.testing.assert_allclose(lengths[:, 0], q[:, 2])
    found = around._depths(arm, q)
    share = np.linspace(0, 1, 400)[:, None, None]
    for number, part in enumerate(("column", "upper link", "gripper")):
        along = points[:, number] + share * (points[:, number + 1] - points[:, number])
        apart = np.linalg.norm(along - around.plant_centre, axis=-1).min(axis=0)
        thick = 0.01 if part != "gripper" else 0.0
        np.testing.assert_allclose(found[part, "plant"], 0.1 + thick - apart, atol=1e-4)
        assert (found[part, "bed"] < 0).all()


# ---- stopping --------------------------------------------------------------------------------


@needs_simulator
def test_an_exception_stops_what_moves() -> None:
    rig = strawberry()
    with pytest.raises(ZeroDivisionError), rig:  # noqa: PT012 - what a program would do
        rig.home()
        simulator, original = simulator_of(rig), rig.link.transport.close

        def close() -> None:
            # Before the line is given up, the motors stand.
            simulator.run(0.5)
            assert all(simulator.state()[f"speed{i}"] == 0 for i in range(3))
            states.append(simulator.state())
            original()

        states: list[dict[str, float]] = []
        simulator.close = close  # type: ignore[method-assign]
        with moving(rig, 1, 600.0):
            raise ZeroDivisionError
    assert len(states) == 1 and states[0]["count1"] < 30_000


@needs_simulator
def test_an_exception_of_the_one_who_watches_stops_what_moves() -> None:
    with strawberry() as rig:
        rig.home()
        begin = rig.link.transport.now()

        def progress(status: RigStatus) -> None:
            if rig.link.transport.now() > begin + 0.5:
                raise KeyboardInterrupt

        rig.progress = progress
        with pytest.raises(KeyboardInterrupt):
            rig.pick(target=TARGET)
        rig.progress = None
        simulator_of(rig).run(0.4)
        assert all(simulator_of(rig).state()[f"speed{i}"] == 0 for i in range(3))
        assert rig.status().state == "idle"
        rig.reset()


@needs_simulator
def test_stop_from_another_thread() -> None:
    with strawberry(surroundings=None) as rig:
        rig.home()
        started = threading.Event()
        rig.progress = lambda status: (started.set(), time.sleep(0.002))[0]
        failures: list[BaseException] = []

        def work() -> None:
            try:
                rig.move([0.6, 0.9, 0.07, 0, 0])
            except BaseException as error:
                failures.append(error)

        thread = threading.Thread(target=work)
        started.clear()
        thread.start()
        assert started.wait(10)
        rig.stop()
        thread.join(10)
        assert not thread.is_alive()
        assert len(failures) == 1 and "the motion was stopped" in str(failures[0])
        simulator_of(rig).run(0.5)
        assert rig.status().state == "idle" and rig.status().q[1] < 0.9
        # Stopping is no fault: the next motion goes.
        rig.progress = None
        rig.move([0.1, 0.1, 0.07, 0, 0])


@needs_simulator
def test_a_stop_between_two_steps_ends_the_sequence() -> None:
    with strawberry() as rig:
        rig.home()
        turn, turned = rig._turn, []

        def then_stop(angles: dict[str, float]) -> list[Arrival]:
            found = turn(angles)
            turned.append(angles)
            rig.stop()
            return found

        rig._turn = then_stop  # type: ignore[method-assign]
        with pytest.raises(RigError, match="the motion was stopped"):
            rig.pick(target=TARGET)
        assert len(turned) == 1
        rig._turn = turn  # type: ignore[method-assign]
        before = rig.link.report().servo[3]
        # The gripper has not closed, and the next motion goes.
        assert before == (2 * 1900)
        rig.reset()


@needs_simulator
def test_motions_of_several_threads_wait_for_one_another() -> None:
    with strawberry(surroundings=None) as rig:
        rig.home()
        failures: list[BaseException] = []

        def work(x: float) -> None:
            try:
                for _ in range(2):
                    rig.move([0.1, x, 0.07, 0, 0])
                    rig.status()
            except BaseException as error:
                failures.append(error)

        threads = [threading.Thread(target=work, args=(x,)) for x in (0.1, 0.15, 0.2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(30)
        assert failures == [] and rig.status().state == "idle"


@needs_simulator
def test_unplugged_on_the_way() -> None:
    with strawberry() as rig:
        rig.home()
        process = simulator_of(rig)._process

        def progress(status: RigStatus) -> None:
            process.kill()
            process.wait()

        rig.progress = progress
        with pytest.raises(LinkError, match="simulated: the line broke"):
            rig.move([0.3, 0.3, 0.07, 0, 0])


@needs_simulator
def test_a_fault_on_the_way_is_raised() -> None:
    with strawberry() as rig:
        rig.home()
        begin = rig.link.transport.now()

        def progress(status: RigStatus) -> None:
            if rig.link.transport.now() > begin + 0.8:
                simulator_of(rig).set("estop", 1)

        rig.progress = progress
        with pytest.raises(RigFaultError, match="the board reports estop; motors are off until"):
            rig.pick(target=TARGET)
        rig.progress = None
        simulator_of(rig).set("estop", 0)
        with pytest.raises(RigFaultError, match="estop"):
            rig.gripper(True)
        rig.clear()
        rig.reset()


@needs_simulator
def test_connecting_twice() -> None:
    with strawberry() as rig, pytest.raises(RigError, match="is connected already"):
        rig.connect()
