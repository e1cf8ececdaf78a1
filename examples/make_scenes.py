"""Make the scene files of the examples that are not written by hand."""

import json
import sys
from pathlib import Path

from agrik_fast.collision import greenhouse_document, leaf, stem

SCENES = Path(__file__).parent / "scenes"


def main(folder: Path) -> None:
    """Write the files into a folder."""
    folder.mkdir(exist_ok=True)
    greenhouse = greenhouse_document(1, plants=4, leaves=8, clear_band=(0.65, 1.3))
    objects = [json.dumps(one) for one in greenhouse.pop("objects")]
    head = json.dumps(greenhouse)[:-1]
    text = f'{head}, "objects": [\n' + ",\n".join(objects) + "\n]}\n"
    (folder / "greenhouse.json").write_text(text, encoding="utf-8")
    parts = (
        leaf("left", (0.65, -0.15, 1.1), 0.1, azimuth=2.8, tilt=0.4, points=20),
        leaf("right", (0.62, 0.12, 1.25), 0.09, azimuth=-2.6, tilt=0.1, points=20),
        stem("stem", (0.74, 0.0, 0.4), (0.75, 0.02, 1.6)),
    )
    lines = ["x,y,z,label"]
    for label, part in enumerate(parts, start=1):
        points = [row[:3] for row in part.spheres.tolist()]
        for row in part.capsules.tolist():
            a, b = row[:3], row[3:6]
            points = [[p + k / 24 * (q - p) for p, q in zip(a, b, strict=True)] for k in range(25)]
        lines += [",".join(f"{1e3 * x:.1f}" for x in point) + f",{label}" for point in points]
    (folder / "crop.csv").write_text("\n".join([*lines, ""]), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else SCENES)
