"""Record what docs/hardware.md shows: a move, a pick, a cut cable, and the 24 experiments.

``python tools/rig_traces.py`` writes docs/hardware/*.csv (needs `make firmware`); a test compares
them with a new run, so that pages can be made where there is no simulator.
"""

from __future__ import annotations

import csv
import sys
import tempfile
from pathlib import Path

from agrik_fast.drivers import LinkError, RigStatus, Simulator, StrawberryRig
from agrik_fast.papers.strawberry import _firmware

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "hardware"
NEAR = {f"slide{i}.carriage": 4.0 for i in range(3)}
HEADER = ["time_s", "s10_mm", "s21_mm", "s32_mm", "true_s10_mm", "true_s21_mm", "true_s32_mm"]
HEADER += ["theta_deg", "beta_deg", "psi_deg", "gripper_deg"]


def _rows(file: Path, rig: StrawberryRig, home: dict[str, float]) -> list[list[str]]:
    """Return a trace in joint values: encoders, and where the carriages really are."""
    with file.open(encoding="utf-8") as stream:
        raw = list(csv.DictReader(stream))
    begin = float(raw[0]["time_s"])
    rows = []
    for row in raw:
        axes = list(enumerate(rig.calibration.axis))
        shown = [
            axis.home_mm + (float(row[f"count{i}"]) - home[f"count{i}"]) / axis.counts_per_mm
            for i, axis in axes
        ]
        true = [axis.home_mm + float(row[f"carriage{i}_mm"]) for i, axis in axes]
        servos = [float(row[f"servo{i}_deg"]) for i in range(4)]
        values = [float(row["time_s"]) - begin, *shown, *true, *servos]
        rows.append([f"{values[0]:.3f}", *(f"{value:.2f}" for value in values[1:])])
    return rows


def record() -> dict[str, list[list[str]]]:
    """Return the rows of move.csv, pick.csv and cable.csv."""
    found = {}
    for name, every in (("move", 0.005), ("pick", 0.02), ("cable", 0.005)):
        simulator = Simulator("strawberry", numbers=NEAR)
        with (
            tempfile.TemporaryDirectory() as folder,
            StrawberryRig(simulator, surroundings=None) as rig,
        ):
            rig.home()
            home, file = simulator.state(), Path(folder) / "trace.csv"
            simulator.trace(file, every)
            if name == "pick":
                rig.pick(target=[0.426, 0.345, -0.3316])
                rig.reset()
            elif name == "move":
                rig._slide({1: 0.18})
                simulator.run(0.2)
            else:
                begin = simulator.now()

                def cut(
                    status: RigStatus, simulator: Simulator = simulator, begin: float = begin
                ) -> None:
                    simulator.set("cable", simulator.now() < begin + 0.5)

                rig.progress = cut
                try:
                    rig._slide({1: 0.6})
                except LinkError:
                    simulator.run(0.5)
                rig.progress = None
            simulator.trace(None)
            found[name] = _rows(file, rig, home)
            simulator.set("cable", 1)
    return found


def main() -> None:
    """Write all files."""
    FOLDER.mkdir(exist_ok=True)
    for name, rows in record().items():
        with (FOLDER / f"{name}.csv").open("w", encoding="utf-8", newline="") as stream:
            csv.writer(stream, lineterminator="\n").writerows([HEADER, *rows])
    with tempfile.TemporaryDirectory() as folder:
        found = _firmware.outcomes(lambda line: print(line, file=sys.stderr))
        for path in _firmware.write(Path(folder), found):
            if path.name in ("experiments24.csv", "experiments24.md"):
                (FOLDER / path.name).write_bytes(path.read_bytes())


if __name__ == "__main__":
    main()
