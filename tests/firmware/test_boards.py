"""The boards' programs in the simulator: size, load, exactness, and the same bits every time."""

import csv
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from agrik_fast.drivers import Calibration, TomatoRig
from agrik_fast.drivers._messages import Move, Servos, State, Type
from rigs import FIRMWARE, SIMULATOR, changed, simulator_of, strawberry, tomato

pytestmark = SIMULATOR
PLAYLESS = {f"slide{i}.play": 0.0 for i in range(3)}


def size(program: str) -> tuple[int, int]:
    """Return bytes of flash and of static RAM."""
    text = subprocess.run(
        ["avr-size", FIRMWARE / "build" / program], capture_output=True, text=True, check=True
    ).stdout
    code, data, bss = map(int, re.findall(r"\d+", text.splitlines()[1])[:3])
    return code + data, data + bss


def test_programs_fit_their_boards() -> None:
    flash, ram = size("mega8.elf")
    assert flash < 0.6 * 8192 and ram < 0.5 * 1024
    flash, ram = size("mega2560.elf")
    assert flash < 0.1 * 262144 and ram < 0.2 * 8192
    assert b"hang" not in (FIRMWARE / "build" / "mega2560.elf").read_bytes()


def test_only_builds_for_tests_can_be_told_to_hang() -> None:
    for rig in (strawberry(), tomato()):
        with rig:
            assert rig.link.request(Type.HANG) == b"\x01"  # unknown
            rig.link.ping(b"still there")


def one_move(
    tmp_path: Path, speed: float, counts_per_mm: float = 107.37, axes: tuple[int, ...] = (0,)
) -> dict[str, float]:
    """Move axes from home by 100 mm; return what the encoder of the first shows."""
    calibration = changed(
        Calibration.load("strawberry"),
        speed_mm_s=speed,
        backlash_mm=0.0,
        counts_per_mm=counts_per_mm,
    )
    numbers = {**PLAYLESS, **{f"slide{i}.counts_per_mm": counts_per_mm for i in range(3)}}
    with strawberry(numbers, calibration=calibration, surroundings=None) as rig:
        rig.home()
        simulator = simulator_of(rig)
        home, start = rig.link.report().position, simulator.state()
        file = tmp_path / "move.csv"
        simulator.trace(file, 0.001)
        begin = simulator.now()
        rig._slide({i: rig.calibration.axis[i].home_mm / 1000 + 0.1 for i in axes})
        simulator.trace(None)
        report, end = rig.link.report(), simulator.state()
        assert report.skips == 0
        for i in range(3):
            # The board's counts are the encoder's own, to the last one.
            assert report.position[i] - home[i] == end[f"count{i}"] - start[f"count{i}"]
        with file.open() as stream:
            rows = [(float(r["time_s"]), float(r["count0"])) for r in csv.DictReader(stream)]
        zero = start["count0"] - home[0]
        way = np.array([(time - begin, (count - zero) / counts_per_mm) for time, count in rows])
        late = way[np.abs(way[:, 1] - 100) > 0.5]
        awake = end["cycle"] - start["cycle"] - (end["slept"] - start["slept"])
        return {
            "settles": float(late[-1, 0]),
            "overshoot": float(way[:, 1].max() - 100),
            "final": float(way[-1, 1] - 100),
            "lost": report.lost_ticks,
            "skips": report.skips,
            "busy": awake / (end["cycle"] - start["cycle"]),
        }


@pytest.mark.parametrize("speed", [90.0, 200.0])
def test_one_axis_settles_in_time(speed: float, tmp_path: Path) -> None:
    seen = one_move(tmp_path, speed)
    assert seen["settles"] < 1.3
    assert seen["overshoot"] < 0.3
    assert abs(seen["final"]) <= 0.3
    assert seen["lost"] == seen["skips"] == 0
    assert seen["busy"] < 0.9


def test_three_axes_at_once_and_fast(tmp_path: Path) -> None:
    seen = one_move(tmp_path, 300.0, axes=(0, 1, 2))
    assert seen["settles"] < 1.3 and seen["overshoot"] < 0.5
    assert seen["lost"] == seen["skips"] == 0
    assert 0.2 < seen["busy"] < 0.9


def test_the_encoder_may_sit_on_the_output_shaft(tmp_path: Path) -> None:
    # A count is 0.28 mm there.
    seen = one_move(tmp_path, 90.0, counts_per_mm=3.579)
    assert seen["settles"] < 1.4 and seen["overshoot"] < 0.6 and abs(seen["final"]) <= 0.56
    assert seen["lost"] == 0


def test_runs_are_the_same_bits_every_time(tmp_path: Path) -> None:
    def run(number: int) -> tuple[bytes, dict[str, float], list[float]]:
        file = tmp_path / f"{number}.csv"
        with strawberry({"servo0.noise": 0.1, "slide1.slip": 0.003}) as rig:
            simulator_of(rig).trace(file, 0.001)
            rig.home()
            run = rig.pick(target=[0.426, 0.345, -0.3316])
            simulator_of(rig).trace(None)
            return file.read_bytes(), simulator_of(rig).state(), [step.end for step in run.steps]

    first, again = run(1), run(2)
    assert len(first[0]) > 100_000
    assert first == again


def let_pass(rig: TomatoRig, seconds: float) -> None:
    """Let time pass, with a sign of life now and then."""
    end = simulator_of(rig).now() + seconds
    while (left := end - simulator_of(rig).now()) > 0:
        rig.link.ping()
        simulator_of(rig).run(min(left, 0.4))


def test_servo_pulses_of_both_boards() -> None:
    with strawberry() as rig:
        simulator = simulator_of(rig)
        rig.home()
        for us in (1000, 1256, 1500, 1999.5):
            servo = rig.calibration.servo[1]
            rig._turn({"beta": servo.angle(round(2 * us))})
            assert abs(simulator.state()["pulse1"] - us) < 0.2
        rig.gripper(True)
        assert abs(simulator.state()["pulse3"] - 1900) < 0.2
    with tomato() as arm:
        simulator = simulator_of(arm)
        arm.home()
        for ticks in ((1600, 4400, 1800), (4400, 1600, 4200), (3001, 2999, 3333)):
            arm.link.command(Type.SERVOS, Servos(1, *ticks).pack())
            let_pass(arm, 2.0)
            state = simulator.state()
            for i, wanted in enumerate(ticks):
                assert abs(state[f"pulse{i}"] - wanted / 2) < 3.0
            before = state["pulses0"]
            let_pass(arm, 1.0)
            # 50 a second.
            assert abs(simulator.state()["pulses0"] - before - 50) <= 2


def test_ramps_of_the_tomato_board() -> None:
    with tomato() as arm:
        simulator = simulator_of(arm)
        arm.home()
        for flags, rate in ((1, 200.0), (3, 60.0)):
            arm.link.command(Type.SERVOS, Servos(flags, 1600, 3000, 3000).pack())
            let_pass(arm, 2.0)
            arm.link.command(Type.SERVOS, Servos(flags, 4000, 3000, 3000).pack())
            start = simulator.state()["pulse0"]
            simulator.run(0.4)
            turned = (simulator.state()["pulse0"] - start) / 8.485
            assert abs(turned / (0.4 * rate) - 1) < 0.15
            let_pass(arm, 4.0)


def test_board_s_clock_is_right_and_it_sleeps() -> None:
    for rig in (strawberry(), tomato()):
        with rig:
            simulator = simulator_of(rig)
            before, start = rig.status().clock, simulator.now()
            simulator.run(5.0)
            after = rig.status()
            assert abs((after.clock - before) - (simulator.now() - start)) < 0.003
            assert after.lost_ticks == 0
            state = simulator.state()
            assert state["slept"] / state["cycle"] > 0.85


def test_what_the_board_refuses() -> None:
    with strawberry() as rig:
        link, move = rig.link, Move(0, 1000, 20000)
        answers = {
            "not homed": (Type.MOVE, move.pack(), 5),
            "no such axis": (Type.MOVE, Move(3, 0, 1).pack(), 2),
            "too short": (Type.MOVE, move.pack()[:-1], 2),
            "too long": (Type.STOP, b"\0", 2),
            "no axis": (Type.HOME, b"\0", 2),
            "unknown axes": (Type.HOME, b"\x08", 2),
            "pulse too short": (Type.SERVO, b"\x00\xaf\x04", 4),
            "pulse too long": (Type.SERVO, b"\x00\xc1\x12", 4),
            "no such servo": (Type.SERVO, b"\x04\xb8\x0b", 2),
            "another board's": (Type.SERVOS, bytes(7), 1),
        }
        for why, (kind, payload, code) in answers.items():
            assert link.request(kind, payload) == bytes([code]), why
        rig.home()
        assert link.request(Type.MOVE, Move(0, -1, 20000).pack()) == b"\x04"
        assert link.request(Type.MOVE, Move(0, 70000, 20000).pack()) == b"\x04"
        assert link.request(Type.MOVE, Move(0, 60000, 20000).pack()) == b"\x00"
        # On its way already, and neither homing nor another calibration then.
        assert link.request(Type.MOVE, Move(0, 0, 20000).pack()) == b"\x03"
        assert link.request(Type.HOME, b"\x01") == b"\x03"
        rig.stop()
        simulator_of(rig).run(0.45)
        assert rig.link.report().state == State.IDLE
    with tomato() as arm:
        assert arm.link.request(Type.SERVOS, Servos(1, 1599, 3000, 3000).pack()) == b"\x04"
        assert arm.link.request(Type.SERVOS, Servos(1, 3000, 3000, 4201).pack()) == b"\x04"
        assert arm.link.request(Type.MOVE, Move(0, 0, 1).pack()) == b"\x01"


def test_an_unconfigured_board_does_not_move() -> None:
    from agrik_fast.drivers import Link, Simulator

    with Link(Simulator("strawberry")) as link:
        link.hello()
        assert link.request(Type.HOME, b"\x07") == b"\x06"
        assert link.request(Type.MOVE, Move(0, 0, 1).pack()) == b"\x06"
