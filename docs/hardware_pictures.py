"""Draw and tabulate what hardware.md shows, from the protocol and from recorded runs."""

from __future__ import annotations

import csv
import tomllib
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt

from agrik_fast.plots import BAD, GOOD, PAGE_WIDTH, PALE, PALETTE

ROOT = Path(__file__).resolve().parents[1]
RECORDS = Path(__file__).parent / "hardware"
COLORS = dict(zip(("s10", "s21", "s32"), PALETTE, strict=False))

MEGA = (
    ("encoder s10: A, B", "D21, D20", "PD0, PD1", "in"),
    ("encoder s21: A, B", "D19, D18", "PD2, PD3", "in"),
    ("encoder s32: A, B", "D2, D3", "PE4, PE5", "in"),
    ("motor driver PWM: s10, s21, s32", "D6, D7, D8", "PH3, PH4, PH5", "out"),
    ("motor driver direction", "D22, D23, D24", "PA0, PA1, PA2", "out"),
    ("limit switches", "D37, D36, D35", "PC0, PC1, PC2", "in"),
    ("emergency stop", "D53", "PB0", "in"),
    ("servos θ, β, ψ", "D46, D45, D44", "PL3, PL4, PL5", "out"),
    ("gripper", "D11", "PB5", "out"),
    ("host", "USB", "PE0, PE1", "both"),
)
MEGA8 = (
    ("shoulder", "15", "PB1", "out"),
    ("elbow", "16", "PB2", "out"),
    ("pan", "17", "PB3", "out"),
    ("host: RXD, TXD", "2, 3", "PD0, PD1", "both"),
    ("16 MHz crystal", "9, 10", "XTAL1, XTAL2", "in"),
)


def read(name: str) -> dict[str, np.ndarray]:
    """Return a recorded run, by column."""
    with (RECORDS / f"{name}.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}


def save(figure: plt.Figure, file: Path) -> None:
    """Write a picture, the same bytes every time."""
    figure.savefig(file, metadata={"Date": None})
    plt.close(figure)


def draw_wiring(
    file: Path, board: str, pins: tuple[tuple[str, str, str, str], ...], column: str
) -> None:
    """Draw a board with what hangs on its pins."""
    height = 0.42 * len(pins) + 0.9
    figure, axes = plt.subplots(figsize=(PAGE_WIDTH, height), layout="constrained")
    axes.add_patch(
        mpl.patches.Rectangle((6.0, -0.5), 2.8, len(pins), facecolor="#d6e7f3", edgecolor="0.4")
    )
    axes.text(7.4, len(pins) - 0.15, board, ha="center", va="bottom", weight="bold")
    axes.text(5.3, len(pins) - 0.15, column, ha="center", va="bottom")
    for row, (what, header, port, way) in enumerate(reversed(pins)):
        box = (0.0, row - 0.36), 4.1, 0.72
        axes.add_patch(mpl.patches.Rectangle(*box, facecolor="#eeeeee", edgecolor="0.4"))
        axes.text(2.05, row, what, ha="center", va="center")
        style = {"in": "->", "out": "<-", "both": "<->"}[way]
        arrow = {"arrowstyle": style, "color": GOOD, "linewidth": 1.6}
        axes.annotate("", xy=(6.0, row), xytext=(4.1, row), arrowprops=arrow)
        axes.text(5.05, row + 0.08, header, ha="center", va="bottom")
        axes.text(7.4, row, port, ha="center", va="center")
    axes.set_xlim(-0.2, 9.2)
    axes.set_ylim(-0.9, len(pins) + 0.3)
    axes.axis("off")
    save(figure, file)


def draw_move(file: Path) -> None:
    """Draw one axis going 100 mm: encoder, carriage, and how far from the end."""
    run = read("move")
    figure, (way, near) = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 2.9), layout="constrained")
    way.plot(run["time_s"], run["s21_mm"], color=GOOD, label="encoder")
    way.plot(run["time_s"], run["true_s21_mm"], "--", color="black", label="carriage")
    end = run["s21_mm"][-1]
    near.plot(run["time_s"], run["s21_mm"] - end, color=GOOD, label="encoder")
    near.plot(run["time_s"], run["true_s21_mm"] - end, "--", color="black", label="carriage")
    near.axhspan(-0.5, 0.5, color=PALE, label="0.5 mm")
    near.set_ylim(-3, 1)
    near.set_xlim(0.5, 0.9)
    for axes in (way, near):
        axes.set_xlabel("time [s]")
        axes.legend()
    way.set_ylabel("s21 [mm]")
    near.set_ylabel("less its end [mm]")
    save(figure, file)


def draw_pick(file: Path) -> None:
    """Draw a command sequence and the way back."""
    run = read("pick")
    figure, (slides, servos) = plt.subplots(
        2, 1, figsize=(PAGE_WIDTH, 4.4), sharex=True, layout="constrained"
    )
    for name, color in COLORS.items():
        slides.plot(run["time_s"], run[f"{name}_mm"], color=color, label=name)
    for name, style in (("theta", "-"), ("beta", "--"), ("psi", ":"), ("gripper", "-.")):
        servos.plot(run["time_s"], run[f"{name}_deg"], style, label=name)
    slides.set_ylabel("encoders [mm]")
    servos.set_ylabel("servos [°]")
    servos.set_xlabel("time [s]")
    for axes in (slides, servos):
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4)
    save(figure, file)


def draw_cable(file: Path) -> None:
    """Draw what a slide does whose cable is cut."""
    run = read("cable")
    figure, axes = plt.subplots(figsize=(PAGE_WIDTH, 2.9), layout="constrained")
    time, speed = run["time_s"], np.gradient(run["s21_mm"], run["time_s"])
    axes.plot(time, speed, color=GOOD)
    axes.axvline(0.5, color=BAD, linestyle="--", label="cable cut")
    still = time[np.flatnonzero(np.abs(speed) > 1)[-1]]
    axes.axvline(still, color="black", linestyle=":", label=f"stands, after {still - 0.5:.2f} s")
    axes.set_xlim(0, still + 0.3)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("speed of s21 [mm/s]")
    axes.legend()
    save(figure, file)


def draw_experiments(file: Path) -> None:
    """Draw times and errors of the 24 experiments."""
    with (RECORDS / "experiments24.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    figure, (times, errors) = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 3.6), layout="constrained")
    times.axhspan(4, 6, color=PALE, label="published range")
    errors.axhspan(0, 10, color=PALE, label="published range")
    for method, color in zip(("ncos", "ssas", "as"), PALETTE, strict=False):
        own = [row for row in rows if row["method"] == method]
        numbers = [int(row["run"]) for row in own]
        times.plot(
            numbers, [float(row["time_s"]) for row in own], "o", color=color, label=method.upper()
        )
        largest = [float(row["error_largest_mm"]) for row in own]
        errors.plot(numbers, largest, "o", color=color, label=method.upper())
    printed = [(int(r["run"]), float(r["time_published_s"])) for r in rows if r["time_published_s"]]
    times.plot(*zip(*printed, strict=True), "x", color="black", label="printed, table 4")
    times.set_ylabel("time [s]")
    errors.set_ylabel("largest error of an axis [mm]")
    for axes in (times, errors):
        axes.set_xlabel("run")
    figure.legend(*times.get_legend_handles_labels(), loc="outside lower center", ncols=5)
    times.set_ylim(3.6, 6.8)
    errors.set_ylim(-0.5, 12.5)
    save(figure, file)


def messages() -> str:
    """Return the table of messages, as Markdown."""
    data = tomllib.loads((ROOT / "firmware" / "messages.toml").read_text(encoding="utf-8"))
    lines = ["| type | message | payload | answer |", "|---|---|---|---|"]
    for name, message in data["message"].items():
        fields = message.get("fields", [])
        # Asterisks would be the marks of emphasis.
        parts = [f"{field} {kind.replace('*', ' × ')}" for field, kind in fields]
        payload = ", ".join(parts) or message.get("payload", "")
        answer = "" if message["type"] >= 0x80 else message.get("reply", "ack").upper()
        note = " (test builds)" if message.get("test_only") else ""
        boards = message.get("boards")
        where = f" ({boards[0]})" if boards else ""
        lines.append(
            f"| `{message['type']:02X}` | {name.upper()}{where}{note} | {payload} | {answer} |"
        )
    return "\n".join(lines) + "\n"


def main(folder: Path) -> None:
    """Write everything into `folder`."""
    folder.mkdir(exist_ok=True, parents=True)
    draw_wiring(folder / "mega2560.svg", "Arduino Mega 2560", MEGA, "header")
    draw_wiring(folder / "mega8.svg", "ATmega8 (DIP-28)", MEGA8, "pin")
    draw_move(folder / "move.svg")
    draw_pick(folder / "pick.svg")
    draw_cable(folder / "cable.svg")
    draw_experiments(folder / "experiments24.svg")
    (folder / "messages.md").write_text(messages(), encoding="utf-8")
