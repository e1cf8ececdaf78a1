"""What docs/hardware.md shows is what the rigs do."""

import csv
from pathlib import Path

import numpy as np

import rig_traces
from rigs import SIMULATOR

pytestmark = SIMULATOR


def test_recorded_runs_come_out_again(repo_root: Path) -> None:
    for name, rows in rig_traces.record().items():
        with (repo_root / "docs" / "hardware" / f"{name}.csv").open() as stream:
            header, *kept = list(csv.reader(stream))
        assert header == rig_traces.HEADER
        # Another compiler may shift a tick or two.
        assert abs(len(rows) - len(kept)) <= 3
        count = min(len(rows), len(kept))
        shown, new = np.array(kept[:count], float), np.array(rows[:count], float)
        # 300 mm/s for a few milliseconds, 286 degrees/s for a pulse.
        np.testing.assert_allclose(new[:, :7], shown[:, :7], rtol=0, atol=1.5)
        np.testing.assert_allclose(new[:, 7:], shown[:, 7:], rtol=0, atol=6.5)
        np.testing.assert_allclose(new[-1, 1:], shown[-1, 1:], rtol=0, atol=0.5)
