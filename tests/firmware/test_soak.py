"""Two simulated minutes of each rig with random targets and faults; `rigs-full` has an hour."""

import pytest

from rigs import SIMULATOR
from rigs_soak import soak

pytestmark = [*SIMULATOR, pytest.mark.timeout(600)]


@pytest.mark.parametrize("rig", ["strawberry", "tomato"])
def test_two_minutes_of_work_and_faults(rig: str) -> None:
    record = soak(rig, 2.0, seed=1)
    print("\n".join(record.lines()))
    assert record.wrong == []
    assert record.motions >= 15 and len(record.faults) >= 2
    assert record.encoder_error_mm <= 0.5 and record.home_drift_mm < 0.3
    assert record.count_error == record.lost_ticks == record.skips == 0
    assert record.memory_kib < 4096
