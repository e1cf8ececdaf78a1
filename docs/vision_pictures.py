"""Draw and tabulate what vision.md shows: everything is rendered, found and computed anew."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt

from agrik_fast.plots import PAGE_WIDTH, PNG_DPI
from agrik_fast.vision import (
    KINDS,
    Camera,
    Detector,
    Fruit,
    Leaf,
    Scene,
    StereoPair,
    annotated,
    budget,
    paper_camera,
    random_scene,
    render,
    write_image,
)

SEED = 7


def draw_kinds(file: Path) -> None:
    camera = paper_camera()
    detector = Detector(camera)
    tiles = []
    for kind in KINDS:
        image = render(random_scene(kind, SEED), camera).image
        tiles.append(annotated(image, camera, detector.detect(image)))
    rows = [np.hstack(tiles[i : i + 4]) for i in range(0, len(tiles), 4)]
    write_image(file, np.vstack(rows))


def draw_depth(file: Path) -> None:
    camera = Camera.of_view(640, 480, 60)
    pair = StereoPair(camera, 0.06)
    scene = Scene(
        (Fruit((-0.02, -0.03, 0.40), 0.033), Fruit((0.09, 0.06, 0.45), 0.030)),
        (
            Leaf((-0.09, 0.04, 0.43), (1.0, 0.3, 0.1), (0.2, 0.1, -1.0), 0.12, 0.07),
            Leaf((0.12, -0.05, 0.50), (0.3, 1.0, 0.1), (-0.3, 0.1, -1.0), 0.15, 0.05),
        ),
        seed=2,
    )
    right = np.eye(4)
    right[0, 3] = pair.baseline
    one, other = (render(scene, camera, pose=pose) for pose in (np.eye(4), right))
    off = 1000 * (pair.depth(one.image, other.image) - one.depth)
    figure, axes = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 2.4), layout="constrained")
    axes[0].imshow(one.image[..., ::-1])
    axes[0].set_title("left picture")
    shown = axes[1].imshow(off, cmap="RdBu", vmin=-20, vmax=20)
    axes[1].set_title("stereo depth (white: none found)")
    figure.colorbar(shown, ax=axes[1], label="less the true depth [mm]")
    for each in axes:
        each.axis("off")
    figure.savefig(file, dpi=PNG_DPI)
    plt.close(figure)


def budget_table() -> str:
    good, paper = budget(0.3), budget(0.3, calibrated=False)
    lines = ["| term, mm | as the paper (assumed) | calibrated |", "|---|---|---|"]
    lines += [
        f"| {name} | {1000 * paper.terms[name]:.1f} | {1000 * value:.1f} |"
        for name, value in good.terms.items()
        if value
    ]
    totals = [f"{1000 * each.total:.1f} ({each.percent:.1f} %)" for each in (paper, good)]
    return "\n".join([*lines, f"| root of squares | {totals[0]} | {totals[1]} |"]) + "\n"


def main(folder: Path) -> None:
    """Write everything into `folder`."""
    folder.mkdir(exist_ok=True, parents=True)
    mpl.rcParams["svg.hashsalt"] = "agrik_fast"
    draw_kinds(folder / "kinds.png")
    draw_depth(folder / "depth.png")
    (folder / "budget.md").write_text(budget_table(), encoding="utf-8")
