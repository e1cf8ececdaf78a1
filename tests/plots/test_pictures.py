"""Pictures of arms, results and scenes: what is on them, and the style of all."""

import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import agrik_fast as ik
from agrik_fast.errors import ArgumentError
from agrik_fast.plots import PAGE_WIDTH, PALETTE, label, space, styled

NAMES = ik.Robot.names()


@pytest.mark.parametrize("name", NAMES)
def test_the_chain_is_drawn_from_base_to_tool(name: str) -> None:
    arm = ik.Robot.load(name)
    parts = arm.surfaces("chain")
    q = arm.random_q(seed=4)
    frames = arm.frames_of(q)
    assert np.abs(frames[1:] - arm.fk_links(q)).max() == 0.0
    # A joint that turns, or a rail with its carriage, for each that moves.
    roles = [part.role for part in parts]
    assert roles.count("rail") == roles.count("carriage")
    for name_, kind in zip(arm.joint_names, arm.joint_types, strict=True):
        wanted = "carriage" if kind == "prismatic" else "joint"
        assert any(part.name == name_ and part.role == wanted for part in parts)
    # Parts that follow one another touch at any posture, for each stands still in its frame.
    corners = [part.placed(frames) for part in parts]
    tip = frames[-1][:3, 3]
    assert min(np.linalg.norm(each - tip, axis=1).min() for each in corners) < 0.12
    for part, placed in zip(parts, corners, strict=True):
        assert np.isfinite(placed).all()
        assert part.faces.max() < len(part.vertices)


@pytest.mark.parametrize("name", ["cucumber", "strawberry", "redundant7"])
def test_surfaces_are_closed_and_seen_from_outside(name: str) -> None:
    for part in ik.Robot.load(name).surfaces("chain"):
        # Every edge is there once in each direction, and the inside has a volume above 0.
        edges = np.concatenate(
            [part.faces[:, [0, 1]], part.faces[:, [1, 2]], part.faces[:, [2, 0]]]
        )
        there = {tuple(edge) for edge in edges.tolist()}
        assert len(there) == len(edges)
        assert {(b, a) for a, b in there} == there
        a, b, c = (part.vertices[part.faces[:, k]] for k in range(3))
        assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() > 0.0


def test_a_rail_is_as_long_as_its_limits() -> None:
    arm = ik.Robot.load("cucumber")
    (rail,) = (part for part in arm.surfaces() if part.role == "rail")
    assert np.ptp(rail.vertices, axis=0).max() == pytest.approx(float(arm.upper[0] - arm.lower[0]))


@pytest.mark.parametrize("name", NAMES)
def test_names_of_axes_are_in_the_picture_and_clear_of_numbers(name: str) -> None:
    arm = ik.Robot.load(name)
    picture = arm.plot(arm.home)
    FigureCanvasAgg(picture).draw()
    (axes,) = picture.axes
    each = (axes.xaxis, axes.yaxis, axes.zaxis)
    numbers = [tick.label1 for axis in each for tick in axis.get_major_ticks()]
    shown = [text.get_window_extent() for text in numbers if text.get_text()]
    assert len(shown) >= 3
    for axis in each:
        box = axis.label.get_window_extent()
        assert picture.bbox.contains(*box.min) and picture.bbox.contains(*box.max)
        assert not any(box.overlaps(other) for other in shown), axis.label.get_text()


def test_blank_axes_are_framed_and_others_stay_as_they_are() -> None:
    arm, scene = ik.Robot.load("cucumber"), ik.collision.greenhouse(seed=1)
    draw = [
        lambda axes: arm.plot(arm.home, view=(10, 20), axes=axes),
        lambda axes: scene.plot(arm, view=(10, 20), axes=axes),
    ]
    for each in draw:
        _, axes = space(4, 4)
        each(axes)
        assert (axes.get_xlabel(), axes.elev, axes.azim) == ("x [m]", 10, 20)
        _, axes = space(4, 4)
        axes.plot([0, 9], [0, 9], [0, 9])
        before = axes.elev, axes.azim
        each(axes)
        assert axes.get_xlabel() == "" and (axes.elev, axes.azim) == before
        assert axes.get_xlim()[1] > 8.9


def test_arms_are_drawn_with_labels_in_metres() -> None:
    arm = ik.Robot.load("panda")
    picture = arm.plot(arm.random_q(4, seed=1), targets=arm.fk(arm.random_q(2, seed=2)))
    assert picture.get_size_inches()[0] == PAGE_WIDTH
    (axes,) = picture.axes
    assert [axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()] == ["x [m]", "y [m]", "z [m]"]
    words = [text.get_text() for text in axes.get_legend().get_texts()]
    assert words == ["way of the tool point", "targets"]
    arm.plot(show="bodies")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"q": [0.0]}, "q"),
        ({"q": [np.nan] * 6}, "q"),
        ({"q": "up"}, "q"),
        ({"show": "x"}, "show"),
        ({"show": "visuals"}, "visuals"),
        ({"targets": [[0.0]]}, "targets"),
    ],
)
def test_wrong_arguments_are_named(arguments: dict, words: str) -> None:
    with pytest.raises(ik.AgrikError, match=words):
        ik.Robot.load("ur5").plot(**arguments)


def test_results_are_drawn_in_words() -> None:
    arm = ik.Robot.load("ur5")
    goals = arm.fk(arm.random_q(40, seed=1))
    goals[::8, 0, 3] += 5.0
    result = arm.ik(goals)
    picture = result.plot()
    bars = [text.get_text() for text in picture.axes[0].get_yticklabels()]
    assert bars == ["converged", "out of reach"]
    assert [axes.get_xlabel() for axes in picture.axes] == [
        "targets",
        "position error [m]",
        "iterations",
    ]
    assert arm.ik(goals[1]).plot(arm).axes[0].get_zlabel() == "z [m]"
    with pytest.raises(ArgumentError, match="arm"):
        result.plot(5)


def test_scenes_are_drawn_with_an_arm_in_them() -> None:
    scene = ik.collision.greenhouse(seed=1)
    arm = ik.Robot.load("cucumber")
    alone, both = scene.plot(), scene.plot(arm, arm.home, skip=["machine"])
    assert len(both.axes[0].collections) > 0 and len(alone.axes[0].collections) > 0
    with pytest.raises(ArgumentError, match="q"):
        scene.plot(q=[0.0])
    with pytest.raises(ArgumentError, match="arm"):
        scene.plot("cucumber")
    ik.Scene().plot()


def test_the_style_of_all_figures() -> None:
    from matplotlib import rcParams

    @styled
    def inside() -> tuple[float, float, str]:
        colours = rcParams["axes.prop_cycle"].by_key()["color"]
        return rcParams["font.size"], rcParams["legend.fontsize"], colours[1]

    assert inside() == (9.0, 9.0, PALETTE[1])
    assert label("time", "s") == "time [s]"


def test_no_figure_has_a_style_of_its_own(repo_root: Path) -> None:
    """Sizes of letters and units after a comma are found where they would come back."""
    sources = [
        *(repo_root / "python/agrik_fast/papers").rglob("*.py"),
        *(repo_root / "python/agrik_fast/harvest").glob("*.py"),
    ]
    assert len(sources) > 30
    for path in sources:
        text = path.read_text(encoding="utf-8")
        assert "fontsize=" not in text, path
        assert not re.search(r'set_[xyz]label\(f?"[^"]*, (?:mm|m|deg|s|rad|%)"', text), path
        for width in re.findall(r"\bfigure\((\d+(?:\.\d+)?),", text):
            assert float(width) <= PAGE_WIDTH, path
