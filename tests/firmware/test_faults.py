"""Everything that may go wrong with a rig: motors are off in time, and the fault has a name."""

import pytest

from agrik_fast.drivers import CommandRefusedError, LinkError, RigFaultError
from agrik_fast.drivers._messages import Move, Servos, Type
from rigs import SIMULATOR, motors_off_at, moving, simulator_of, strawberry, tomato

pytestmark = SIMULATOR


def assert_nothing_moves_until_cleared(rig) -> None:  # type: ignore[no-untyped-def]
    """See that a fault is latched, and that CLEAR leads out of it."""
    simulator, state = simulator_of(rig), rig.status().state
    assert state in ("fault", "estop")
    before = [simulator.state()[f"count{i}"] for i in range(3)]
    for kind, payload in (
        (Type.MOVE, Move(0, 5000, 20000).pack()),
        (Type.SERVO, b"\x00\xb8\x0b"),
        (Type.HOME, b"\x07"),
    ):
        assert rig.link.request(kind, payload) == b"\x03"
    with pytest.raises(RigFaultError):
        rig.home()
    simulator.run(1.0)
    after = [simulator.state()[f"count{i}"] for i in range(3)]
    assert before == after and rig.status().state == state
    rig.clear()
    assert rig.status().state in ("idle", "not_homed")
    assert rig.status().fault == "none"


def assert_works(rig) -> None:  # type: ignore[no-untyped-def]
    """See that the rig is as good as new."""
    rig.home()
    rig.pick(target=[0.426, 0.345, -0.3316])
    assert rig.status().state == "idle" and rig.status().lost_ticks == 0


def test_host_falls_silent() -> None:
    with strawberry() as rig:
        rig.home()
        with moving(rig, 1, 600.0) as simulator:
            last = simulator.now() - 0.4  # of the last good frame
            simulator.run(2.0)
            assert 0.49 < motors_off_at(simulator) - last < 0.51
        status = rig.status()
        assert (status.state, status.fault) == ("fault", "link_timeout")
        assert_nothing_moves_until_cleared(rig)
        assert_works(rig)


def test_noise_is_no_sign_of_life() -> None:
    with strawberry() as rig:
        rig.home()
        with moving(rig, 1, 600.0) as simulator:
            last = simulator.now() - 0.4
            for byte in range(200):
                simulator.write(bytes([byte, 0, 3, byte]))
                simulator.run(0.01)
            assert 0.49 < motors_off_at(simulator) - last < 0.51
        assert rig.status().fault == "link_timeout"


def test_cable_cut_and_plugged_in_again() -> None:
    with strawberry() as rig:
        rig.home()
        simulator = simulator_of(rig)
        rig.progress = lambda status: simulator.set("cable", status.q[1] < 0.3)
        with pytest.raises(LinkError, match=r"no answer to STATUS after 5 tries"):
            rig.move([0.1, 0.7, 0.07, 0.0, 0.0])
        simulator.run(1.0)
        cut = simulator.state()
        assert all(cut[f"driven{i}"] == 0 for i in range(3))
        # Half a second, and what the slide still coasts, behind where the line was cut.
        assert 0.3 < 0.08 + cut["carriage1"] / 1000 < 0.45
        rig.progress = None
        simulator.set("cable", 1)
        assert rig.status().fault == "link_timeout"
        assert_nothing_moves_until_cleared(rig)
        assert_works(rig)


def test_jam() -> None:
    with strawberry() as rig:
        rig.home()
        with moving(rig, 0, 400.0) as simulator:
            begin = simulator.now()
            simulator.set("slide0.jammed", 1)
            simulator.run(0.3)
            assert motors_off_at(simulator) - begin < 0.15
        status = rig.status()
        assert (status.fault, status.fault_axis) == ("stall", "s10")
        simulator.set("slide0.jammed", 0)
        assert_nothing_moves_until_cleared(rig)
        assert_works(rig)


def test_jam_from_the_start_is_named_by_the_driver() -> None:
    with strawberry({"slide2.jammed": 1}) as rig:
        with pytest.raises(RigFaultError, match="switch not found of axis s32") as caught:
            rig.home()
        assert caught.value.fault == "switch_not_found"


def test_a_weak_motor_falls_behind() -> None:
    with strawberry() as rig:
        rig.home()
        simulator_of(rig).set("slide1.top_speed", 150.0)
        with pytest.raises(RigFaultError, match="following of axis s21"):
            rig.move([0.1, 0.7, 0.07, 0.0, 0.0])


@pytest.mark.parametrize(("stuck", "fault"), [(1.0, "switch_stuck"), (-1.0, "switch_not_found")])
def test_switch_stuck_while_homing(stuck: float, fault: str) -> None:
    with strawberry({"slide2.stuck": stuck}) as rig:
        with pytest.raises(RigFaultError) as caught:
            rig.home()
        assert (caught.value.fault, caught.value.axis) == (fault, "s32")
        motors_off_at(simulator_of(rig))
        simulator_of(rig).set("slide2.stuck", 0)
        assert_nothing_moves_until_cleared(rig)
        assert_works(rig)


def test_switch_pressed_on_the_way() -> None:
    with strawberry() as rig:
        rig.home()
        with moving(rig, 1, 600.0) as simulator:
            begin = simulator.now()
            simulator.set("slide1.stuck", 1)
            simulator.run(0.3)
            assert motors_off_at(simulator) - begin < 0.005
        status = rig.status()
        assert (status.fault, status.fault_axis) == ("limit_switch", "s21")
        assert status.switches == ("s21",)
        simulator.set("slide1.stuck", 0)
        assert_nothing_moves_until_cleared(rig)


def test_emergency_stop() -> None:
    with strawberry() as rig:
        rig.home()
        with moving(rig, 1, 600.0) as simulator:
            begin = simulator.now()
            simulator.set("estop", 1)
            simulator.run(0.3)
            assert motors_off_at(simulator) - begin < 0.0025
        status = rig.status()
        assert (status.state, status.fault, status.switches) == ("estop", "estop", ("estop",))
        with pytest.raises(CommandRefusedError, match="refuses to clear the fault: wrong state"):
            rig.clear()
        simulator.set("estop", 0)
        simulator.run(0.1)
        assert rig.status().state == "estop"
        assert_nothing_moves_until_cleared(rig)
        assert_works(rig)


def test_emergency_stop_wins_over_a_fault() -> None:
    with strawberry() as rig:
        rig.home()
        with moving(rig, 1, 600.0) as simulator:
            simulator.set("slide1.jammed", 1)
            simulator.run(0.3)
            assert rig.status().fault == "stall"
            simulator.set("estop", 1)
            simulator.run(0.1)
        assert rig.status().state == "estop"


def test_program_hangs() -> None:
    with strawberry(test_build=True) as rig:
        rig.home()
        with moving(rig, 1, 600.0) as simulator:
            begin = simulator.now()
            with pytest.raises(LinkError, match="no answer to HANG"):
                rig.link.request(Type.HANG, tries=1)
            simulator.run(1.0)
            assert 0.2 < motors_off_at(simulator) - begin < 0.3
            assert simulator.state()["resets"] == 1
        status = rig.status()
        # Not even the calibration has survived, and nobody has to guess why.
        assert (status.state, status.fault, status.homed) == ("fault", "watchdog", False)
        assert rig.link.hello().reset == 3
        assert_nothing_moves_until_cleared(rig)
        rig._prepare()
        assert_works(rig)


def test_stop_on_the_way_is_no_fault() -> None:
    with strawberry() as rig:
        rig.home()
        with moving(rig, 1, 600.0) as simulator:
            begin = simulator.now()
            rig.stop()
            for _ in range(10):
                simulator.run(0.1)
                rig.link.ping()
            assert motors_off_at(simulator) - begin < 0.4
        assert rig.status().state == "idle" and rig.status().homed


# ---- tomato --------------------------------------------------------------------------------------


def test_tomato_holds_and_lets_go_when_the_host_falls_silent() -> None:
    with tomato() as rig:
        rig.home()
        simulator = simulator_of(rig)
        rig.link.command(Type.SERVOS, Servos(3, 4000, 2000, 3000).pack())
        last = simulator.now()
        simulator.run(0.6)
        held = simulator.state()
        simulator.run(1.0)
        # It stands where the silence was noticed, half a second on its way.
        assert simulator.state()["pulse0"] == pytest.approx(held["pulse0"], abs=3)
        assert simulator.state()["pulse0"] < 1990
        simulator.run(5.0)
        ended = max(simulator.state()[f"seen{i}"] for i in range(3)) / 16e6
        assert 4.95 < ended - last < 5.05
        assert rig.status().fault == "link_timeout"
        assert rig.link.request(Type.SERVOS, Servos(1, 3000, 3000, 3000).pack()) == b"\x03"
        before = simulator.state()["pulses0"]
        simulator.run(0.5)
        assert simulator.state()["pulses0"] == before
        rig.clear()
        rig.home()
        assert rig.status().state == "idle"


def test_tomato_at_rest_lets_go_without_a_fault() -> None:
    with tomato() as rig:
        rig.home()
        simulator_of(rig).run(6.0)
        status = rig.status()
        assert (status.state, status.fault) == ("idle", "none")
        assert rig.link.report().busy == 0
        rig.home()


def test_tomato_s_program_hangs() -> None:
    with tomato(test_build=True) as rig:
        rig.home()
        simulator = simulator_of(rig)
        begin = simulator.now()
        with pytest.raises(LinkError, match="no answer to HANG"):
            rig.link.request(Type.HANG, tries=1)
        simulator.run(1.0)
        state = simulator.state()
        assert state["resets"] == 1
        assert max(state[f"seen{i}"] for i in range(3)) / 16e6 - begin < 0.35
        assert rig.status().fault == "watchdog"
        with pytest.raises(RigFaultError, match="watchdog"):
            rig.home()
        rig.clear()
        rig.home()
