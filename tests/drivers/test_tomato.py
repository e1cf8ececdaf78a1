"""The tomato rig's driver, on the board's program and simulated servos."""

import numpy as np
import pytest

from agrik_fast.arms import HOME
from agrik_fast.drivers import OutOfReachError, RigError, RigStatus, TomatoRig
from agrik_fast.errors import ArgumentError
from rigs import SIMULATOR, simulator_of, tomato

pytestmark = SIMULATOR


def tip(rig: TomatoRig) -> np.ndarray:
    """Return where the servos really bring the tool point, m."""
    state = simulator_of(rig).state()
    return rig.arm.fk(np.radians([state[f"angle{i}"] for i in range(3)]))


# Wide dead bands and noise are what a servo of this class may have.
NOISE = {f"servo{i}.noise": 0.1 for i in range(3)}
EXACT = {f"servo{i}.dead_band": 0.0 for i in range(3)}


def test_home_and_targets() -> None:
    random = np.random.default_rng(1)
    with tomato(EXACT) as rig:
        rig.home()
        assert rig.status().q == pytest.approx(HOME, abs=2e-3)
        for _ in range(20):
            target = rig.arm.fk(random.uniform(rig.lower, rig.upper))
            begin = rig.link.transport.now()
            status = rig.move(target=target)
            assert status.state == "idle" and rig.link.transport.now() - begin < 2.5
            # Half microseconds are 0.06 degrees, over 0.32 m.
            np.testing.assert_allclose(tip(rig), target, rtol=0, atol=1.5e-3)


def test_with_dead_band_droop_and_noise() -> None:
    with tomato({**NOISE, "droop0": 1.14, "droop1": 0.36}) as rig:
        rig.home()
        for target in ([0.2, 0.05, 0.1], [0.15, -0.06, 0.08], [0.24, 0.0, 0.12]):
            rig.move(target=target)
            off = np.linalg.norm(tip(rig) - target)
            # The arm yields, so that nobody can miss by nothing.
            assert 0.0005 < off < 0.012


def test_slowly_near_the_fruit() -> None:
    with tomato() as rig:
        rig.home()
        times = []
        for near in (False, True):
            rig.move([1.0, -1.5, 0.0])
            begin = rig.link.transport.now()
            rig.move([2.0, -1.5, 0.0], near=near)
            times.append(rig.link.transport.now() - begin)
        # 57 degrees at 200 and at 60 a second.
        assert times[1] - times[0] == pytest.approx(57.3 / 60 - 57.3 / 200, abs=0.1)


def test_follow_at_thirty_a_second() -> None:
    seen: list[RigStatus] = []
    with tomato(EXACT, progress=seen.append) as rig:
        rig.home()
        time = np.arange(60) / 30
        path = np.array(HOME) + 0.3 * np.sin(time[:, None] * [1.0, 1.3, 1.7])
        begin = rig.link.transport.now()
        rig.follow(path)
        assert 1.9 < rig.link.transport.now() - begin < 2.4
        np.testing.assert_allclose(rig.status().q, path[-1], atol=2e-3)
        assert len(seen) > 60
        with pytest.raises(ArgumentError, match=r"`path`: expected shape \(n, 3\), n >= 1"):
            rig.follow([])
        with pytest.raises(ArgumentError, match=r"`phi3`: expected -60.00 to 60.00 degrees, got"):
            rig.follow([HOME, [1.0, -1.5, 2.0]])
        with pytest.raises(ArgumentError, match="`rate`"):
            rig.follow(path, rate=0)


def test_what_is_refused() -> None:
    with tomato() as rig:
        with pytest.raises(OutOfReachError, match="is out of reach: too far"):
            rig.move(target=[0.9, 0.0, 0.0])
        with pytest.raises(OutOfReachError, match="is out of reach: servo limit"):
            rig.move(target=[-0.2, 0.0, -0.1])
        with pytest.raises(ArgumentError, match=r"`phi1`: expected 7.50 to 172.50 degrees, got 0"):
            rig.move([0.0, -1.5, 0.0])
        with pytest.raises(ArgumentError, match="`target`: expected finite numbers, m"):
            rig.move(target=[0.2, np.nan, 0.0])
        with pytest.raises(ArgumentError, match="`near`"):
            rig.move(HOME, near=1)  # type: ignore[arg-type]
        with pytest.raises(RigError, match="the tomato rig has no gripper"):
            rig.gripper(True)
        # None of it has moved a servo.
        assert simulator_of(rig).state()["pulses0"] == 0


def test_release_ends_the_pulses() -> None:
    with tomato() as rig:
        rig.home()
        rig.release()
        before = simulator_of(rig).state()["pulses0"]
        simulator_of(rig).run(0.5)
        assert simulator_of(rig).state()["pulses0"] <= before + 1
        assert np.isnan(rig.status().q).all()
        rig.home()


def test_an_exception_holds_the_arm() -> None:
    with tomato() as rig:
        rig.home()
        rig.move([0.6, -1.5, 0.0])
        begin = rig.link.transport.now()

        def progress(status: RigStatus) -> None:
            if rig.link.transport.now() > begin + 0.2:
                raise KeyboardInterrupt

        rig.progress = progress
        with pytest.raises(KeyboardInterrupt):
            rig.move([2.8, -1.5, 0.0])
        rig.progress = None
        held = rig.status()
        assert held.state == "idle" and 0.7 < held.q[0] < 2.0
        simulator_of(rig).run(0.4)
        assert rig.status().q == pytest.approx(held.q, abs=1e-3)
