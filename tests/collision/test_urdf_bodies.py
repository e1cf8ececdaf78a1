"""Bodies from the collision geometry of a URDF, its meshes among it."""

from __future__ import annotations

import math
import pickle
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
import trimesh

import agrik_fast as ik
from agrik_fast._bodies._hulls import MOST_CORNERS, hull_of, overestimate, point_triangle
from agrik_fast.collision import Box, Capsule, Convex, Cover, Scene, SceneObject, Sphere
from agrik_fast.errors import AgrikError, ArgumentError, UrdfError

LIMITS = '<limit lower="-2" upper="2" effort="1" velocity="1"/>'


def link(name: str, *solids: str, visual: bool = False) -> str:
    parts = [f"<collision>{solid}</collision>" for solid in solids]
    shown = "<visual><geometry><box size='1 1 1'/></geometry></visual>" if visual else ""
    return f'<link name="{name}">{shown}{"".join(parts)}</link>'


def solid(geometry: str, origin: str = "") -> str:
    return f"{origin}<geometry>{geometry}</geometry>"


def joint(parent: str, child: str, kind: str = "revolute", origin: str = "") -> str:
    axis = '<axis xyz="0 0 1"/>' if kind != "fixed" else ""
    return (
        f'<joint name="to_{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f"{origin}{axis}{LIMITS if kind != 'fixed' else ''}</joint>"
    )


def urdf(*parts: str) -> str:
    return f'<robot name="r">{"".join(parts)}</robot>'


def arm_with(*solids: str, **options: object) -> ik.Robot:
    text = urdf(link("base"), link("tip", *solids), joint("base", "tip"))
    return ik.Robot.from_urdf(text, **options)  # type: ignore[arg-type]


def arm_beside(folder: Path, *solids: str, **options: object) -> ik.Robot:
    text = urdf(link("base"), link("tip", *solids), joint("base", "tip"))
    (folder / "arm.urdf").write_text(text)
    return ik.Robot.from_urdf(folder / "arm.urdf", **options)  # type: ignore[arg-type]


def fault(arm: ik.Robot) -> str:
    with pytest.raises(UrdfError) as caught:
        arm.bodies  # noqa: B018 - read when it is asked for
    return str(caught.value)


def test_every_solid_becomes_a_body_of_its_link() -> None:
    turn = '<origin xyz="0.1 0.2 0.3" rpy="0 1.5707963267948966 0"/>'
    arm = ik.Robot.from_urdf(
        urdf(
            link("base", solid('<box size="0.2 0.4 0.6"/>')),
            link("one", solid('<sphere radius="0.05"/>', turn), visual=True),
            link("tip", solid('<cylinder radius="0.1" length="0.6"/>', turn),
                 solid('<capsule radius="0.1" length="0.6"/>')),
            joint("base", "one", origin='<origin xyz="0 0 1"/>'),
            joint("one", "tip"),
        )
    )  # fmt: skip
    base, ball, rod, capsule = arm.bodies
    assert [body.name for body in arm.bodies] == ["base", "one", "tip:0", "tip:1"]
    assert [body.frame for body in arm.bodies] == [0, 1, 2, 2]
    assert base.shape == Box((0, 0, 0), (0.1, 0.2, 0.3)) and base.overestimate == 0.0
    assert ball.shape == Sphere((0.1, 0.2, 0.3), 0.05) and ball.provenance == "URDF"
    assert isinstance(rod.shape, Capsule) and rod.shape.radius == 0.1 and rod.overestimate == 0.1
    np.testing.assert_allclose(rod.shape.a, [-0.2, 0.2, 0.3], atol=1e-15)
    np.testing.assert_allclose(rod.shape.b, [0.4, 0.2, 0.3], atol=1e-15)
    assert capsule.shape == Capsule((0, 0, -0.3), (0, 0, 0.3), 0.1)
    assert capsule.overestimate == 0.0
    assert pickle.loads(pickle.dumps(arm)).bodies == arm.bodies
    assert arm.with_tool(np.eye(4)).bodies == arm.bodies


def test_what_a_cylinder_becomes() -> None:
    cylinder = solid('<cylinder radius="0.1" length="0.6"/>')
    (prism,) = arm_with(cylinder, cylinder="convex").bodies
    assert isinstance(prism.shape, Convex) and len(prism.shape.vertices) == 32
    assert prism.overestimate == pytest.approx(0.0196 * 0.1, rel=2e-3)
    corners = np.array(prism.shape.vertices)
    np.testing.assert_allclose(np.hypot(*corners[:, :2].T), 0.1 / math.cos(math.pi / 16))
    # Every point of the cylinder is in it.
    angles = np.linspace(0, 2 * math.pi, 1000)
    sides = 2 * math.pi * np.arange(16) / 16 + math.pi / 16
    reach = np.cos(angles[:, None] - sides).max(axis=1) * 0.1
    assert reach.max() <= 0.1 + 1e-15 and np.ptp(corners[:, 2]) == pytest.approx(0.6)
    (cover,) = arm_with(cylinder, cylinder="cover").bodies
    assert isinstance(cover.shape, Cover) and cover.shape.half == (0.1, 0.1, 0.3)
    with pytest.raises(AgrikError, match="unknown cylinder 'box'"):
        arm_with(cylinder, cylinder="box")
    with pytest.raises(AgrikError, match="unknown mesh 'box'"):
        arm_with(cylinder, mesh="box")
    with pytest.raises(ArgumentError, match="mesh_folders"):
        arm_with(cylinder, mesh_folders="folder")


def test_links_off_the_chain_stand_still_on_it(tmp_path: Path) -> None:
    text = urdf(
        link("world", solid('<box size="1 1 1"/>')),
        link("base", solid('<sphere radius="0.1"/>')),
        link("arm", solid('<sphere radius="0.1"/>')),
        link("hand", solid('<sphere radius="0.1"/>')),
        link("camera", solid('<sphere radius="0.02"/>')),
        link("finger", solid('<sphere radius="0.01"/>'), solid('<sphere radius="0.01"/>')),
        link("nail", solid('<sphere radius="0.005"/>')),
        link("cover", visual=True),
        joint("world", "base", "fixed"),
        joint("base", "arm"),
        joint("arm", "hand"),
        joint("arm", "camera", "fixed", '<origin xyz="0 0.1 0"/>'),
        joint("hand", "finger", "prismatic", '<origin xyz="0 0 0.2"/>'),
        joint("finger", "nail", "fixed", '<origin xyz="0 0 0.1"/>'),
        joint("hand", "cover", "fixed"),
    )
    (tmp_path / "arm.urdf").write_text(text)
    arm = ik.Robot.from_urdf(tmp_path / "arm.urdf", "base", "hand")
    with pytest.warns(UserWarning, match="arm.urdf: ") as told:
        bodies = {body.name: body for body in arm.bodies}
    assert list(bodies) == ["base", "arm", "camera", "hand", "finger:0", "finger:1", "nail"]
    assert [body.frame for body in bodies.values()] == [0, 1, 1, 2, 2, 2, 2]
    assert bodies["camera"].shape == Sphere((0, 0.1, 0), 0.02)
    nail = bodies["nail"].shape
    assert isinstance(nail, Sphere)
    np.testing.assert_allclose(nail.centre, [0, 0, 0.3])
    words = [str(one.message) for one in told]
    assert len(words) == 3
    assert "<visual> geometry and no <collision>" in words[0] and "cover" in words[0]
    assert "joints outside the chain move, taken at zero: finger, nail" in words[1]
    assert "above the base link 'base', left out: world" in words[2]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert arm.bodies[0].name == "base"  # told once


@pytest.mark.parametrize(
    ("geometry", "words"),
    [
        ('<box size="1 1"/>', "<box> size: expected 3 finite numbers, got '1 1'"),
        ('<box size="1 1 -1"/>', "<box> half: expected half lengths >= 0 m"),
        ('<sphere radius="nan"/>', "<sphere> radius: expected 1 finite numbers, got 'nan'"),
        ('<sphere radius="-1"/>', "<sphere> radius: expected a length >= 0, got -1"),
        ('<cylinder radius="1"/>', "<cylinder> length: expected 1 finite numbers, got None"),
        ("<mesh/>", "<mesh> has no filename"),
        ('<mesh filename="a.stl" scale="1"/>', "<mesh> scale: expected 3 finite numbers"),
        ("<cone/>", "<cone> is no known solid"),
        ("", "<collision> with 0 solids in its <geometry>, expected one"),
    ],
)
def test_solids_that_make_no_sense(geometry: str, words: str) -> None:
    text = fault(arm_with(solid(geometry)))
    assert text.startswith("URDF: link 'tip': ") and words in text
    assert "<origin> xyz" in fault(arm_with(solid('<sphere radius="1"/>', '<origin xyz="0 0 x"/>')))


# ---- meshes ---------------------------------------------------------------------------------


@pytest.fixture
def wedge() -> trimesh.Trimesh:
    """A mesh that is not convex: two boxes that make an L, 0.1 m and 0.2 m long."""
    first = trimesh.creation.box((0.2, 0.02, 0.02))
    second = trimesh.creation.box((0.02, 0.1, 0.02))
    second.apply_translation((0.09, 0.05, 0.0))
    return trimesh.util.concatenate([first, second])


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "dae"])
def test_a_mesh_becomes_its_hull(tmp_path: Path, wedge: trimesh.Trimesh, suffix: str) -> None:
    wedge.export(tmp_path / f"wedge.{suffix}")
    origin = '<origin xyz="0 0 0.5"/>'
    arm = arm_beside(tmp_path, solid(f'<mesh filename="wedge.{suffix}" scale="1 2 1"/>', origin))
    (body,) = arm.bodies
    assert isinstance(body.shape, Convex) and body.shape.radius == 0.0
    corners = np.array(body.shape.vertices)
    points = wedge.vertices * [1, 2, 1] + [0, 0, 0.5]
    np.testing.assert_allclose(corners.max(axis=0), points.max(axis=0), atol=1e-7)
    np.testing.assert_allclose(corners.min(axis=0), points.min(axis=0), atol=1e-7)
    # The middle of the slanting side is as far from one leg of the L as from the other.
    assert body.overestimate == pytest.approx(0.09, rel=0.02)


def test_the_unit_of_a_collada_file_counts(tmp_path: Path) -> None:
    trimesh.creation.box((200.0, 400.0, 600.0)).export(tmp_path / "box.dae")
    text = (tmp_path / "box.dae").read_text()
    unit = '<unit name="millimetre" meter="0.001"/><up_axis>'
    (tmp_path / "box.dae").write_text(text.replace("<up_axis>", unit))
    (body,) = arm_beside(tmp_path, solid('<mesh filename="box.dae"/>')).bodies
    assert isinstance(body.shape, Convex)
    np.testing.assert_allclose(np.ptp(body.shape.vertices, axis=0), [0.2, 0.4, 0.6], rtol=1e-6)


def test_a_convex_mesh_is_met_exactly(tmp_path: Path) -> None:
    box = trimesh.creation.box((0.2, 0.4, 0.6))
    box.export(tmp_path / "box.stl")
    (body,) = arm_beside(tmp_path, solid('<mesh filename="box.stl"/>')).bodies
    assert isinstance(body.shape, Convex) and len(body.shape.vertices) == 8
    assert body.overestimate == 0.0
    (cover,) = arm_beside(tmp_path, solid('<mesh filename="box.stl"/>'), mesh="cover").bodies
    assert isinstance(cover.shape, Cover)
    np.testing.assert_allclose(cover.shape.half, [0.1, 0.2, 0.3], rtol=1e-6)


def test_a_file_of_several_meshes_becomes_several_hulls(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    for k in range(3):
        part = trimesh.creation.icosphere(radius=0.1)
        part.apply_translation((k, 0, 0))
        scene.add_geometry(part)
    scene.export(tmp_path / "parts.glb")
    bodies = arm_beside(tmp_path, solid('<mesh filename="parts.glb"/>')).bodies
    assert [body.name for body in bodies] == ["tip:0", "tip:1", "tip:2"]


def test_hulls_have_few_corners_and_hold_all_points() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.1)
    hull = hull_of(ball.vertices)
    assert len(hull.vertices) == MOST_CORNERS and 0 < hull.radius < 0.02
    # With its radius every point is within: asked of the core, which knows nothing of this.
    arm = ik.Robot.from_dh([[0, 0, 0, 0]]).attach(hull, name="hull")
    for corner in ball.vertices[::97]:
        point = SceneObject.of("point", Sphere(tuple(corner), 0.0))
        assert Scene([point]).clearance(arm, [0.0]) <= 1e-12
    assert overestimate(hull, ball.triangles) == pytest.approx(hull.radius, rel=1e-6)
    flat = hull_of(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0.0]]))
    assert len(flat.vertices) == 5 and flat.radius == 0.0
    many = np.random.default_rng(1).random((500, 3)) * [1, 1, 0]
    sheet = hull_of(many)
    assert len(sheet.vertices) == MOST_CORNERS and sheet.radius < 0.3
    assert hull_of(np.zeros((5, 3))).vertices == ((0.0, 0.0, 0.0),)


def test_the_distance_of_points_from_triangles() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    points = np.array([[0.2, 0.2, 0.5], [2, 0, 0], [-1, -1, 0], [1, 1, 0], [0.5, -1, 1]])
    triangles = np.broadcast_to(corners, (5, 3, 3))
    np.testing.assert_allclose(
        point_triangle(points, triangles), [0.5, 1, math.sqrt(2), math.sqrt(0.5), math.sqrt(2)]
    )
    needle = np.array([[[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]])
    np.testing.assert_allclose(point_triangle(np.array([[1.0, 3, 4]]), needle), [5.0])


def test_packages_are_looked_for_where_ros_keeps_them(
    tmp_path: Path, wedge: trimesh.Trimesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh = solid('<mesh filename="package://my_arm/meshes/wedge%20a.stl"/>')
    (tmp_path / "my_arm" / "meshes").mkdir(parents=True)
    (tmp_path / "my_arm" / "urdf").mkdir()
    wedge.export(tmp_path / "my_arm" / "meshes" / "wedge a.stl")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    assert len(arm_beside(tmp_path / "my_arm" / "urdf", mesh).bodies) == 1
    assert len(arm_beside(tmp_path, mesh).bodies) == 1
    assert len(arm_with(mesh, mesh_folders=[tmp_path]).bodies) == 1
    assert len(arm_with(mesh, mesh_folders=[str(tmp_path / "my_arm")]).bodies) == 1
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere:{tmp_path}")
    assert len(arm_beside(elsewhere, mesh).bodies) == 1
    path = tmp_path / "my_arm" / "meshes" / "wedge a.stl"
    for name in (f"file://{path}", str(path)):
        assert len(arm_with(solid(f'<mesh filename="{name}"/>')).bodies) == 1


def test_a_missing_mesh_says_where_it_was_looked_for(tmp_path: Path) -> None:
    text = fault(arm_beside(tmp_path, solid('<mesh filename="meshes/arm.stl"/>')))
    assert "link 'tip': mesh file 'meshes/arm.stl' is missing; looked for at" in text
    assert str(tmp_path / "meshes" / "arm.stl") in text
    text = fault(arm_beside(tmp_path, solid('<mesh filename="package://pkg/arm.stl"/>')))
    assert str(tmp_path / "pkg" / "arm.stl") in text
    assert str(tmp_path.parent / "pkg" / "arm.stl") in text
    text = fault(arm_with(solid('<mesh filename="arm.stl"/>')))
    assert "the URDF came as text, and no folder of meshes was given (`mesh_folders`)" in text
    # Plain kinematics needs no meshes.
    arm = arm_with(solid('<mesh filename="arm.stl"/>'))
    assert arm.ik(arm.fk([0.3])[:3, 3]).success


def test_broken_meshes_name_link_and_file(tmp_path: Path, wedge: trimesh.Trimesh) -> None:
    wedge.export(tmp_path / "whole.stl")
    whole = (tmp_path / "whole.stl").read_bytes()
    for name, data in {
        "cut.stl": whole[: len(whole) // 2],
        "empty.stl": b"",
        "text.stl": b"solid nothing\nendsolid\n",
        "noise.obj": bytes(range(256)) * 8,
        "bad.dae": b"<COLLADA>",
        "odd.xyz9": whole,
    }.items():
        (tmp_path / name).write_bytes(data)
        text = fault(arm_beside(tmp_path, solid(f'<mesh filename="{name}"/>')))
        assert f"link 'tip': mesh file '{tmp_path / name}'" in text, text
        assert "cannot be read" in text and len(text.splitlines()) == 1
    nan = wedge.copy()
    nan.vertices[0] = np.nan
    nan.export(tmp_path / "nan.stl")
    text = fault(arm_beside(tmp_path, solid('<mesh filename="nan.stl"/>')))
    assert "not finite" in text or "cannot be read" in text


def test_without_trimesh_the_extra_is_named(
    tmp_path: Path, wedge: trimesh.Trimesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    wedge.export(tmp_path / "wedge.stl")
    monkeypatch.setitem(sys.modules, "trimesh", None)
    text = fault(arm_beside(tmp_path, solid('<mesh filename="wedge.stl"/>')))
    assert "needs trimesh and SciPy; install agrik_fast[meshes]" in text


def test_a_real_arm_s_bodies_are_where_its_links_are(repo_root: Path) -> None:
    """Spheres put on every link of the iiwa meet the scene where its kinematics says."""
    text = (repo_root / "tests/data/iiwa14.urdf").read_text()
    chain = ik.Robot.from_urdf(text)
    for name in chain.link_names[:-1]:
        ball = "<collision><geometry><sphere radius='0.01'/></geometry></collision>"
        for old in (f'<link name="{name}"/>', f'<link name="{name}">'):
            tail = "</link>" if old.endswith("/>") else ""
            text = text.replace(old, f'<link name="{name}">{ball}{tail}')
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        arm = ik.Robot.from_urdf(text)
        names = [body.name for body in arm.bodies]
    q = arm.random_q(20, seed=4)
    frames = chain.fk_links(q)
    scene = Scene([SceneObject.of("far", Sphere((5, 5, 5), 1))])
    found = scene.distances(arm, q)
    for k, name in enumerate(chain.link_names[:-1]):
        which = next(i for i, body in enumerate(names) if body.split(":")[0] == name)
        own = found.distance[:, which]
        expected = np.linalg.norm(frames[:, k, :3, 3] - 5, axis=1) - 1.01
        np.testing.assert_allclose(own, expected, atol=1e-12)
