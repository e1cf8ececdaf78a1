"""Depth to obstacles: the reference's stereo pair, covering balls, matched pixels, long fruits."""

import json
import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from agrik_fast.collision import from_document
from agrik_fast.errors import ArgumentError
from agrik_fast.vision import (
    Camera,
    DetectionStatus,
    Detector,
    Fruit,
    Leaf,
    Scene,
    StereoPair,
    VisionFileError,
    Wall,
    balls_that_cover,
    from_boxes,
    from_masks,
    fruit_radius,
    green_masks,
    long_fruit,
    obstacles,
    paper_camera,
    read_image,
    render,
    triangulate,
)

DATA = Path(__file__).resolve().parents[1] / "data" / "vision"
STEREO: dict[str, Any] = json.loads((DATA / "reference.json").read_text())["stereo"]
CAMERA = Camera.from_matrix(640, 480, STEREO["K"], STEREO["dist"])
PAIR = StereoPair(CAMERA, STEREO["baseline_m"])
LEFT = read_image(DATA / STEREO["left"])
RIGHT = read_image(DATA / STEREO["right"])
DEPTH = PAIR.depth(LEFT, RIGHT)
FRUITS = Detector(CAMERA).detect(LEFT)


def test_leaves_of_the_references_pair() -> None:
    for each in STEREO["true_depth_points"]:
        off = np.array([DEPTH[int(v), int(u)] - z for u, v, z in each["uv_depth"]])
        if each["object"].startswith("leaf"):
            assert (np.abs(off) < 0.003).sum() >= 12, each["object"]
        else:
            # The highlight is seen behind the surface.
            assert np.nanmedian(off) > 0.005


def test_fruits_come_from_their_cones() -> None:
    assert len(FRUITS) == 2
    for truth in STEREO["fruits"]:
        centre = np.array(truth["centre_m"])
        nearest = min(FRUITS, key=lambda d: float(np.hypot(*(d.uv - CAMERA.project(centre)))))
        assert np.linalg.norm(nearest.centre(truth["radius_m"]) - centre) < 0.004
        inside = CAMERA.grid_rays() @ nearest.axis > math.cos(nearest.alpha)
        rows, columns = np.nonzero(inside & np.isfinite(DEPTH))
        rays = CAMERA.rays(np.stack([columns, rows], axis=1).astype(float))
        points = rays / rays[:, 2:] * DEPTH[rows, columns][:, None]
        assert abs(fruit_radius(nearest, points) - truth["radius_m"]) < 0.0025


def test_obstacles_of_the_pair_make_a_scene() -> None:
    masks = green_masks(LEFT, DEPTH)
    # The two leaves, and what noise in the depth has cut off them.
    assert len(masks) >= 2
    assert masks[1].sum() > 10 * sum(mask.sum() for mask in masks[2:])
    document = obstacles(CAMERA, DEPTH, masks, fruits=FRUITS, radius=0.0315)
    names = [each["name"] for each in document["objects"]]
    assert names == [*(f"leaf{i}" for i in range(len(masks))), "fruit0", "fruit1"]
    scene = from_document(document)
    assert scene.names == tuple(names)
    for mask, each in zip(masks[:2], document["objects"], strict=False):
        assert len(each["points"]) >= 15
        centres = np.array(each["points"])
        # Two pixels at the rim are half of what is behind; every point inside lies in some ball.
        for inside, share in (
            (cv2.erode(mask.astype(np.uint8), np.ones((5, 5))) > 0, 0),
            (mask, 0.005),
        ):
            rows, columns = np.nonzero(inside)
            near = np.abs(DEPTH[rows, columns] - np.median(DEPTH[rows, columns])) < 0.05
            rays = CAMERA.rays(np.stack([columns, rows], axis=1)[near].astype(float))
            points = rays / rays[:, 2:] * DEPTH[rows, columns][near][:, None]
            far = np.linalg.norm(points[:, None] - centres, axis=2).min(axis=1)
            assert (far > each["radius"]).mean() <= share
        assert each["radius"] < 0.008


def test_balls_cover_every_point() -> None:
    rng = np.random.default_rng(1)
    for size in (0.001, 0.05, 0.4):
        cloud = rng.uniform(-size, size, (800, 3)) * [1, 1, 0.1]
        centres, radius, covering = balls_that_cover(cloud)
        far = np.linalg.norm(cloud[:, None] - centres, axis=2).min(axis=1)
        assert far.max() <= radius + 1e-12
        assert far.max() == pytest.approx(covering)
        assert 15 <= len(centres) <= 200
    assert len(balls_that_cover(np.zeros((1, 3)))[0]) == 1
    with pytest.raises(ArgumentError, match="`points`"):
        balls_that_cover(np.full((4, 3), np.nan))


def test_the_left_margin_is_seen_where_both_cameras_see_it() -> None:
    # At this distance the right camera misses 83 columns, of the 128 that are tried.
    wall = Scene((), (), Wall(point=(0.0, 0.0, 0.4)), seed=4)
    right = np.eye(4)
    right[0, 3] = PAIR.baseline
    first, second = (render(wall, CAMERA, pose=each) for each in (np.eye(4), right))
    depth = PAIR.depth(first.image, second.image)
    missed = int(CAMERA.fx * PAIR.baseline / 0.4)
    assert missed < 90
    assert np.isfinite(depth[:, missed + 10 : 128]).mean() > 0.6
    assert np.isnan(depth[:, : missed - 10]).mean() > 0.9


def test_a_depth_cameras_holes() -> None:
    depth = np.zeros((480, 640))
    mask = np.zeros((480, 640), bool)
    mask[100:200, 100:220] = True
    depth[mask] = 0.5
    depth[120:140, 130:150] = 0.0
    depth[150:160] = np.nan
    (leaf,) = obstacles(CAMERA, depth, {"left": mask}, pose=np.eye(4))["objects"]
    assert leaf["name"] == "left"
    points = np.array(leaf["points"])
    np.testing.assert_allclose(points[:, 2], 0.5, atol=1e-12)
    assert obstacles(CAMERA, np.zeros((480, 640)), [mask])["objects"] == []
    for argument, bad in (
        ("depth", (CAMERA, depth[:-1], [mask])),
        (r"masks\[leaf0\]", (CAMERA, depth, [mask.astype(float)])),
        (r"masks\[leaf0\]", (CAMERA, depth, [mask[:-1]])),
    ):
        with pytest.raises(ArgumentError, match=argument):
            obstacles(*bad)  # type: ignore[arg-type]


def test_a_pair_is_rectified_and_of_one_size() -> None:
    with pytest.raises(ArgumentError, match="rectified"):
        StereoPair(paper_camera(640), 0.06)
    with pytest.raises(ArgumentError, match="baseline"):
        StereoPair(CAMERA, 0.0)
    with pytest.raises(ArgumentError, match="`right`"):
        PAIR.depth(LEFT, RIGHT[:240, :320])


# ---- matched pixels -----------------------------------------------------------------------------


def matched(tmp_path: Path, text: str) -> Path:
    file = tmp_path / "matches.csv"
    file.write_text(text)
    return file


def test_pixels_matched_by_hand(tmp_path: Path) -> None:
    camera = paper_camera(640)
    pose = np.eye(4)
    pose[:3, 3] = [0.06, 0.002, -0.001]
    rng = np.random.default_rng(3)
    points = rng.uniform([-0.1, -0.08, 0.3], [0.1, 0.08, 0.6], (30, 3))
    left, right = camera.project(points), camera.project(points - pose[:3, 3])
    found = triangulate(np.hstack([left, right]), camera, camera, pose)
    # Twelve rounds of the distortion's inverse leave 1e-9 of a ray.
    np.testing.assert_allclose(found.points, points, atol=1e-6)
    assert np.nanmax(found.gaps) < 1e-6
    rows = "\n".join(
        f"leaf{i % 2},{a[0]!r},{a[1]!r},{b[0]!r},{b[1]!r}"
        for i, (a, b) in enumerate(zip(left.tolist(), right.tolist(), strict=True))
    )
    file = matched(tmp_path, f"# by hand\nname,u_left,v_left,u_right,v_right\n{rows}\n")
    read = triangulate(file, camera, camera, pose)
    np.testing.assert_array_equal(read.points, found.points)
    assert read.names[:2] == ("leaf0", "leaf1")
    behind = triangulate([[300.0, 240.0, 500.0, 240.0]], camera, camera, pose)
    assert np.isnan(behind.points).all()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("u_left,v_left\n1,2\n", "no column u_right, v_right"),
        ("u_left,v_left,u_right,v_right\n1,2,3,x\n", "row 1, column v_right"),
        ("u_left,v_left,u_right,v_right\n1,2,3,4\n1,nan,3,4\n", "row 2, column v_left"),
        ("", "no column u_left"),
    ],
)
def test_faulty_tables(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(VisionFileError, match=words):
        triangulate(matched(tmp_path, text), CAMERA, CAMERA, np.eye(4) + np.eye(4, k=3))


def test_no_table(tmp_path: Path) -> None:
    pose = np.eye(4)
    with pytest.raises(ArgumentError, match="another place"):
        triangulate(np.zeros((1, 4)), CAMERA, CAMERA, pose)
    pose[0, 3] = 0.1
    with pytest.raises(VisionFileError, match=r"none\.csv"):
        triangulate(tmp_path / "none.csv", CAMERA, CAMERA, pose)
    with pytest.raises(ArgumentError, match="`matches`"):
        triangulate(np.zeros((1, 3)), CAMERA, CAMERA, pose)


# ---- others' detectors --------------------------------------------------------------------------


def test_boxes_and_masks() -> None:
    camera = paper_camera()
    picture = render(Scene((Fruit((0.03, 0.02, 0.35), 0.03),)), camera)
    mask = picture.labels == 0
    rows, columns = np.nonzero(mask)
    box = [columns.min() - 0.5, rows.min() - 0.5, columns.max() + 0.5, rows.max() + 0.5]
    (found,) = from_boxes([box], camera)
    assert found.status == DetectionStatus.WEAK
    (found,) = from_boxes([box], camera, trusted=True)
    assert found.status == DetectionStatus.OK
    assert np.hypot(*(found.uv - picture.fruits[0].uv)) < 1.0
    assert abs(found.distance(0.03) / np.linalg.norm(picture.fruits[0].centre) - 1) < 0.03
    (cut,) = from_boxes([[0, 10, 40, 50]], camera, trusted=True)
    assert cut.status == DetectionStatus.EDGE
    (found,) = from_masks(mask[None], Detector(camera))
    assert found.status == DetectionStatus.OK
    assert from_boxes([], camera) == []
    for bad in ([[3, 3, 2, 9]], [[1, 2, 3]], [[np.nan, 1, 2, 3]]):
        with pytest.raises(ArgumentError, match="`boxes"):
            from_boxes(bad, camera)
    with pytest.raises(ArgumentError, match="`masks`"):
        from_masks(mask, Detector(camera))


def test_axis_and_grip_of_a_cucumber() -> None:
    camera = paper_camera(640)
    axis = np.array([0.15, 0.97, 0.19]) / np.linalg.norm([0.15, 0.97, 0.19])
    centre = np.array([0.02, 0.01, 0.45])
    green = Fruit(tuple(centre.tolist()), 0.02, 4.5, tuple(axis.tolist()), (60, 140, 60), red=False)
    # The ball round a long fruit is what the renderer looks in.
    picture = render(Scene((green,)), camera)
    found = long_fruit(picture.labels == 0, picture.depth, camera)
    assert abs(found.axis @ axis) > math.cos(math.radians(6))
    assert found.length == pytest.approx(0.18, rel=0.08)
    assert found.radius == pytest.approx(0.02, rel=0.15)
    middle = (found.top + found.bottom) / 2
    assert np.linalg.norm(middle - centre) < 0.008
    assert found.top[1] < found.bottom[1]
    np.testing.assert_allclose(found.grip, found.top - 0.25 * found.length * found.axis, atol=1e-12)
    ball = render(Scene((Fruit((0, 0, 0.4), 0.03),)), camera)
    with pytest.raises(ArgumentError, match="a long fruit"):
        long_fruit(ball.labels == 0, ball.depth, camera)
    with pytest.raises(ArgumentError, match="too few pixels"):
        long_fruit(np.zeros((480, 640), bool), ball.depth, camera)
    with pytest.raises(ArgumentError, match="`mask`"):
        long_fruit(np.zeros((3, 3), bool), ball.depth, camera)


def test_texture_is_that_of_the_world() -> None:
    leaf = Leaf((0.0, 0.0, 0.45), (1.0, 0.2, 0.0), (0.1, 0.1, -1.0), 0.12, 0.06)
    scene = Scene((), (leaf,), seed=4)
    right = np.eye(4)
    right[0, 3] = PAIR.baseline
    first, second = (render(scene, CAMERA, pose=each) for each in (np.eye(4), right))
    depth = PAIR.depth(first.image, second.image)
    inside = first.labels == 0
    assert np.isfinite(depth[inside]).mean() > 0.9
    off = depth[inside] - first.depth[inside]
    assert abs(np.nanmedian(off)) < 0.0015
