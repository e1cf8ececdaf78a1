"""What stands in the window: the arm, its pale copies, the target, obstacles, clouds, ways."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .._checks import FloatArray
from ..collision import Scene
from ..plots import BAD, GOOD, GREY
from ..robot import Look, Robot
from ._solids import Mesh, arm_meshes, rgb, scene_solids, whole, wxyz

_PALE = 0.22
_PALER = 0.12
# How far the grid on the ground goes to either side, in steps of 0.1 m.
_GROUND = 20
_BLUE, _ORANGE = rgb(GOOD), rgb(BAD)


class Stage:
    """The scene of a server, as far as an arm is concerned.

    Nodes have fresh names with every load: of one that is removed and made again by the same name,
    a browser keeps the turn.

    Parameters
    ----------
    server : viser.ViserServer
    """

    def __init__(self, server: Any) -> None:
        self._server = server
        self._scene = server.scene
        self._loads = 0
        self._arm: list[Any] = []
        self._frames: list[Any] = []
        self._fingers: list[tuple[Mesh, Any]] = []
        self._ghost: Any = None
        self._ghost_frames: list[Any] = []
        self._branches: list[Any] = []
        self._obstacles: list[Any] = []
        self._cloud: Any = None
        self._way: list[Any] = []
        self.handle: Any = None
        self._mark: Any = None
        self._label: Any = None
        # Plain: shadows and a ground without an end are worked out for every point of a picture.
        self._scene.configure_default_lights(enabled=True, cast_shadow=False)
        self._ground()

    def _ground(self) -> None:
        """Draw a grid on the ground: a line every 0.1 m, a darker one every metre."""
        steps = np.arange(-_GROUND, _GROUND + 1) / 10
        ends = np.full_like(steps, _GROUND / 10)
        nothing = np.zeros_like(steps)
        along = np.stack(
            [np.stack([steps, -ends, nothing], 1), np.stack([steps, ends, nothing], 1)], 1
        )
        lines = np.concatenate([along, along[:, :, [1, 0, 2]]]).astype(np.float32)
        whole = np.tile(np.isclose(steps % 1.0, 0.0), 2)
        for name, rows, shade in (("minor", ~whole, 225), ("major", whole, 150)):
            self._scene.add_line_segments(
                f"/ground/{name}",
                lines[rows],
                (shade, shade, shade),
                thickness=1.0,
                thickness_units="screen",
            )

    # -- the arm ---------------------------------------------------------------------------

    def load(self, robot: Robot, show: Look, scale: float) -> None:
        """Take another arm; the target's handle is made anew with it."""
        with self._server.atomic():
            for handle in (*self._arm, *self._branches):
                handle.remove()
            self._branches, self._fingers = [], []
            if self.handle is not None:
                self.handle.remove()  # and its mark and words with it
            self._loads += 1
            self._parts = robot.surfaces(show)
            self._robot = robot
            meshes = arm_meshes(self._parts)
            count = len(robot.link_names) + 1
            root, ghost = f"/arm/{self._loads}", f"/nearest/{self._loads}"
            self._root = self._scene.add_frame(root, show_axes=False)
            self._ghost = self._scene.add_frame(ghost, show_axes=False, visible=False)
            self._arm = [self._root, self._ghost]
            self._frames = [
                self._scene.add_frame(f"{root}/{k}", show_axes=False) for k in range(count)
            ]
            self._ghost_frames = [
                self._scene.add_frame(f"{ghost}/{k}", show_axes=False) for k in range(count)
            ]
            for number, mesh in enumerate(meshes):
                handle = self._mesh(f"{root}/{mesh.frame}/{number}", mesh)
                if mesh.name:
                    self._fingers.append((mesh, handle))
                self._mesh(f"{ghost}/{mesh.frame}/{number}", mesh, _ORANGE, _PALE)
            # Drawn through the arm, which would hide it.
            self.handle = self._scene.add_transform_controls(
                f"/target/{self._loads}", scale=scale * self.handle_size(), depth_test=False
            )
            size = 0.02 * robot.reach_radius
            self._mark = self._scene.add_icosphere(
                f"/target/{self._loads}/mark", size, _BLUE, cast_shadow=False
            )
            self._label = self._scene.add_label(f"/target/{self._loads}/words", "", visible=False)

    def handle_size(self) -> float:
        """Return the size of the target's handle, m."""
        return float(np.clip(0.22 * self._robot.reach_radius, 0.08, 0.5))

    def handle_tips(self, pose: FloatArray) -> FloatArray:
        """Return how far the handle goes at a pose, shape (6, 3), m."""
        axes = self.handle.scale * pose[:3, :3].T
        tips: FloatArray = pose[:3, 3] + np.concatenate([axes, -axes])
        return tips

    def _mesh(self, name: str, mesh: Mesh, colour: Any = None, opacity: float | None = None) -> Any:
        return self._scene.add_mesh_simple(
            name,
            mesh.vertices.astype(np.float32),
            mesh.faces.astype(np.uint32),
            color=colour or mesh.colour,
            opacity=opacity,
            flat_shading=True,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

    def pose(self, q: FloatArray, opening: float = 0.0) -> None:
        """Show the arm at a posture, its hand closed (0) to open (1)."""
        self._place(self._frames, q)
        for mesh, handle in self._fingers:
            handle.position = tuple(opening * np.array(mesh.opens))

    def nearest(self, q: FloatArray | None) -> None:
        """Show a pale copy at the nearest posture that was found; None hides it."""
        self._ghost.visible = q is not None
        if q is not None:
            self._place(self._ghost_frames, q)

    def _place(self, frames: Sequence[Any], q: FloatArray) -> None:
        poses = self._robot.frames_of(q)
        for handle, pose, turn in zip(frames, poses, wxyz(poses), strict=True):
            handle.position = pose[:3, 3]
            handle.wxyz = turn

    def drawn(self) -> FloatArray:
        """Return the frames as they are drawn, shape (links + 1, 4, 4), m."""
        from ..rotations import pose

        return np.array([pose(each.position, quat=np.roll(each.wxyz, -1)) for each in self._frames])

    def opening(self) -> float:
        """Return how far the hand is drawn open, 0 to 1."""
        for mesh, handle in self._fingers:
            way = np.array(mesh.opens)
            return float(np.dot(handle.position, way) / np.dot(way, way))
        return 0.0

    def branches(self, postures: Sequence[FloatArray]) -> None:
        """Show pale copies at postures; of none, take all away."""
        with self._server.atomic():
            for handle in self._branches:
                handle.remove()
            self._loads += 1
            self._branches = []
            for number, q in enumerate(postures):
                vertices, faces = whole(self._parts, self._robot.frames_of(q))
                mesh = Mesh(0, vertices, faces, rgb(GREY))
                name = f"/branches/{self._loads}/{number}"
                self._branches.append(self._mesh(name, mesh, None, _PALER))

    # -- the target ------------------------------------------------------------------------

    def target(self, pose: FloatArray) -> None:
        """Put the target's handle at a pose, shape (4, 4), m."""
        self.handle.position = pose[:3, 3]
        self.handle.wxyz = wxyz(pose[:3, :3])

    def rotations(self, wanted: bool) -> None:
        """Show or hide the handle's rings."""
        self.handle.disable_rotations = not wanted

    def verdict(self, good: bool, words: str) -> None:
        """Show whether the target is reached: by colour, and in words where it is not."""
        self._mark.color = _BLUE if good else _ORANGE
        self._label.visible = not good
        if not good:
            self._label.text = words

    # -- what stands round it ----------------------------------------------------------------

    def obstacles(self, scene: Scene | None, visible: bool = True) -> None:
        """Show the objects of a scene in place of those before."""
        with self._server.atomic():
            for handle in self._obstacles:
                handle.remove()
            self._obstacles = []
            if scene is None or not visible:
                return
            self._loads += 1
            meshes, points = scene_solids(scene)
            for number, mesh in enumerate(meshes):
                self._obstacles.append(
                    self._mesh(f"/scene/{self._loads}/{number}", mesh, None, 0.75)
                )
            for number, cloud in enumerate(points):
                self._obstacles.append(
                    self._scene.add_point_cloud(
                        f"/scene/{self._loads}/cloud{number}",
                        cloud.places.astype(np.float32),
                        cloud.colour,
                        point_size=cloud.size,
                        point_shape="circle",
                        precision="float16",
                    )
                )

    def cloud(self, places: FloatArray | None, colours: Any = None, size: float = 0.01) -> None:
        """Show points in place of those before; None takes them away."""
        if self._cloud is not None:
            self._cloud.remove()
            self._cloud = None
        if places is not None and len(places):
            self._loads += 1
            self._cloud = self._scene.add_point_cloud(
                f"/reach/{self._loads}",
                places.astype(np.float32),
                colours,
                point_size=size,
                point_shape="circle",
                precision="float16",
            )

    def way(self, tips: FloatArray | None, bad: Any = None, targets: Any = None) -> None:
        """Show the way of the tool point, orange where a pose failed or a joint jumped."""
        with self._server.atomic():
            for handle in self._way:
                handle.remove()
            self._way = []
            self._loads += 1
            if tips is not None and len(tips) > 1:
                pieces = np.stack([tips[:-1], tips[1:]], axis=1)
                wrong = np.asarray(bad)[1:]
                for name, rows, colour, wide in (
                    ("good", ~wrong, _BLUE, 3.0),
                    ("bad", wrong, _ORANGE, 6.0),
                ):
                    if rows.any():
                        self._way.append(
                            self._scene.add_line_segments(
                                f"/way/{self._loads}/{name}",
                                pieces[rows].astype(np.float32),
                                colour,
                                thickness=wide,
                                thickness_units="screen",
                            )
                        )
            if targets is not None and len(targets):
                self._way.append(
                    self._scene.add_point_cloud(
                        f"/way/{self._loads}/targets",
                        np.asarray(targets, dtype=np.float32),
                        rgb(GREY),
                        point_size=0.012 * self._robot.reach_radius,
                        point_shape="circle",
                        precision="float32",
                    )
                )
