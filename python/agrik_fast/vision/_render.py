"""A renderer with exact truth: what the tests' and the documentation's pictures are made with.

Four rays a pixel find the nearest of ellipsoids, leaves and a wall. Texture is a function of the
point in the world, or the two pictures of a stereo pair would not match.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks import FloatArray, finite_array, whole_number
from ._camera import Camera
from ._cv import opencv
from ._images import Image, of_kind
from ._scenes import (
    Fruit,
    Leaf,
    Look,
    Patch,
    Scene,
    Wall,
    across,
    cone_rays,
    leaf_hits,
    paper_camera,
)

__all__ = ["FruitTruth", "Rendering", "render"]

_SAMPLES = 2
_AMBIENT, _LAMBERT, _RIM = 0.35, 0.65, 0.06
_LEAF_TEXTURE, _WALL_TEXTURE = 0.12, 0.15
BACKGROUND_LABEL = -1


@dataclass(frozen=True)
class FruitTruth:
    """Where a fruit is in a picture.

    Attributes
    ----------
    centre : ndarray, shape (3,), m
        In the camera's frame.
    radius, flattening : float
        Equatorial radius (m), and its polar over it.
    red : bool
        Whether it is ripe.
    uv : ndarray, shape (2,), pixels
        Projected centre; NaN behind the camera.
    angular_radius : float, rad
        Half angle of the cone in which a sphere of this radius is seen.
    visible : float
        Share of its disc that is in the picture with nothing before it.

    Examples
    --------
    >>> from agrik_fast.vision import Fruit, Scene, render
    >>> picture = render(Scene((Fruit((0, 0, 0.35), 0.03),)))
    >>> picture.fruits[0].centre.tolist()
    [0.0, 0.0, 0.35]
    """

    centre: FloatArray
    radius: float
    flattening: float
    red: bool
    uv: FloatArray
    angular_radius: float
    visible: float


@dataclass(frozen=True)
class Rendering:
    """A picture and the truth about it.

    Attributes
    ----------
    image : ndarray, shape (height, width, 3), uint8
        Blue, green, red.
    fruits : tuple of FruitTruth
        In the scene's order.
    depth : ndarray, shape (height, width), m
        z in the camera's frame of what each pixel's centre sees; NaN for nothing.
    labels : ndarray, shape (height, width)
        What that is: number of a fruit, then of leaves and patches, counted on; the wall comes
        after them, and nothing is -1.
    names : tuple of str
        fruit0, ..., leaf0, ..., patch0, ..., wall: a name for every label.

    Examples
    --------
    >>> from agrik_fast.vision import random_scene, render
    >>> picture = render(random_scene("clean", seed=1))
    >>> picture.image.shape == (*picture.depth.shape, 3)
    True
    """

    image: Image
    fruits: tuple[FruitTruth, ...]
    depth: FloatArray
    labels: NDArray[np.int32]
    names: tuple[str, ...]


class _Texture:
    """Ten plane waves of 3 to 30 mm with random directions and phases, rms about 1."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng([977, seed])
        way = rng.normal(size=(10, 3))
        way /= np.linalg.norm(way, axis=1)[:, None]
        waves = np.exp(rng.uniform(math.log(0.003), math.log(0.03), 10))
        self.waves = (way * (2 * math.pi / waves)[:, None]).astype(np.float32)
        self.phases = rng.uniform(0, 2 * math.pi, 10).astype(np.float32)

    def __call__(self, points: FloatArray) -> NDArray[np.float32]:
        phase = points.astype(np.float32) @ self.waves.T + self.phases
        total: NDArray[np.float32] = np.sin(phase).sum(axis=-1) * np.float32(math.sqrt(0.2))
        return total


class _Canvas:
    """What the rays have hit so far."""

    def __init__(self, scene: Scene, camera: Camera, pose: FloatArray) -> None:
        self.scene, self.camera = scene, camera
        self.origin, self.turn = pose[:3, 3], pose[:3, :3]
        self.rays = camera.grid_rays(_SAMPLES)
        shape = self.rays.shape[:2]
        self.label: NDArray[np.int32] = np.full(shape, BACKGROUND_LABEL, np.int32)
        if scene.wall is None:
            self.far: FloatArray = np.full(shape, np.inf)
            self.colour = np.zeros((*shape, 3), np.float32)
        else:
            far, colour = _background(scene.wall, scene.look, scene.seed, camera, pose.tobytes())
            self.far, self.colour = far.copy(), colour.copy()
            count = len(scene.fruits) + len(scene.leaves) + len(scene.patches)
            self.label[np.isfinite(far)] = count
        self.texture = _Texture(scene.seed)

    def window(self, centre: FloatArray, radius: float) -> tuple[slice, slice] | None:
        """Return rows and columns where a ball can be, or None where it cannot."""
        local = self.turn.T @ (centre - self.origin)
        far = float(np.linalg.norm(local))
        height, width = self.far.shape
        if far <= 1.02 * radius:
            return slice(0, height), slice(0, width)
        axis, sine = local / far, radius / far
        cosine = math.sqrt(1 - sine * sine)
        first, second = across(axis)
        turn = np.linspace(0, 2 * math.pi, 64, endpoint=False)
        rim = cosine * axis + sine * (
            np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * second
        )
        if rim[:, 2].min() < 0.2:
            # Beside or behind the camera: the window cannot be told from the outline.
            return (slice(0, height), slice(0, width)) if rim[:, 2].max() > 0.2 else None
        uv = self.camera.project(rim)
        low = np.floor(_SAMPLES * (uv.min(axis=0) - 2)).astype(int)
        high = np.ceil(_SAMPLES * (uv.max(axis=0) + 3)).astype(int)
        left, top = max(low[0], 0), max(low[1], 0)
        right, bottom = min(high[0], width), min(high[1], height)
        return (slice(top, bottom), slice(left, right)) if left < right and top < bottom else None

    def put(
        self,
        window: tuple[slice, slice],
        hit: NDArray[np.bool_],
        far: FloatArray,
        label: int,
        colour: NDArray[np.float32],
    ) -> None:
        """Keep what is nearer than all before; `far` and `colour` are those of `hit` alone."""
        nearer = far < self.far[window][hit]
        rows, columns = np.nonzero(hit)
        rows, columns = rows[nearer] + window[0].start, columns[nearer] + window[1].start
        self.far[rows, columns] = far[nearer]
        self.label[rows, columns] = label
        self.colour[rows, columns] = colour[nearer]

    # ---- shading -----------------------------------------------------------------------------

    def shade(
        self,
        albedo: NDArray[np.float32] | FloatArray,
        normals: FloatArray,
        rays: FloatArray,
        gloss: float = 0.0,
    ) -> NDArray[np.float32]:
        """Return colours by ambient and Lambert's light, Blinn and Phong's highlight, a rim."""
        look = self.scene.look
        light = np.array(look.light)
        lambert = np.clip(normals @ light, 0, None)
        colour = albedo * (_AMBIENT + _LAMBERT * lambert)[..., None]
        if gloss > 0:
            half = light - rays
            half /= np.linalg.norm(half, axis=-1)[..., None]
            shine = np.clip(np.einsum("...i,...i", normals, half), 0, None) ** look.shininess
            facing = np.clip(-np.einsum("...i,...i", normals, rays), 0, 1)
            colour = colour + (255 * gloss * shine * (lambert > 0))[..., None]
            colour = colour * (1 + _RIM * (1 - facing) ** 3)[..., None]
        return np.asarray(colour, np.float32)

    def fruit(self, number: int, fruit: Fruit) -> None:
        centre = np.array(fruit.centre)
        window = self.window(centre, fruit.radius * max(fruit.flattening, 1.0))
        if window is None:
            return
        rays = self.rays[window] @ self.turn.T
        far, hit = ellipsoid_hits(fruit, self.origin, rays)
        rays, far = rays[hit], far[hit]
        points = self.origin + far[:, None] * rays
        axis = np.array(fruit.axis)
        outward = points - centre
        # The gradient of the ellipsoid's equation.
        stretch = 1 / fruit.flattening**2 - 1
        normals = outward + stretch * (outward @ axis)[:, None] * axis
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        albedo = np.broadcast_to(np.array(fruit.colour, np.float32), normals.shape)
        if fruit.texture:
            albedo = albedo * (1 + fruit.texture * self.texture(points))[:, None]
        colour = self.shade(albedo, normals, rays, self.scene.look.gloss)
        self.put(window, hit, far, number, colour)

    def leaf(self, number: int, leaf: Leaf) -> None:
        centre = np.array(leaf.centre)
        window = self.window(centre, math.hypot(leaf.length, leaf.width) / 2)
        if window is None:
            return
        rays = self.rays[window] @ self.turn.T
        far, hit = leaf_hits(leaf, self.origin, rays)
        rays, far = rays[hit], far[hit]
        points = self.origin + far[:, None] * rays
        normal, along = np.array(leaf.normal), np.array(leaf.along)
        side = np.abs((points - centre) @ np.cross(normal, along)) / leaf.width
        vein = 1 + 0.5 * np.exp(-((side / 0.025) ** 2))
        albedo = (
            np.array(leaf.colour, np.float32)
            * (vein * (1 + _LEAF_TEXTURE * self.texture(points))).astype(np.float32)[:, None]
        )
        # A leaf is lit from either side.
        normals = np.where((rays @ normal > 0)[:, None], -normal, normal)
        self.put(window, hit, far, number, self.shade(albedo, normals, rays))

    def patch(self, number: int, patch: Patch) -> None:
        centre = np.array(patch.centre)
        window = self.window(centre, math.hypot(patch.width, patch.height) / 2)
        if window is None:
            return
        rays = self.rays[window] @ self.turn.T
        normal, along = np.array(patch.normal), np.array(patch.along)
        with np.errstate(divide="ignore", invalid="ignore"):
            far = ((centre - self.origin) @ normal) / (rays @ normal)
            off = self.origin + far[..., None] * rays - centre
            # Rows run along, and down as seen by whoever looks at the face.
            x = off @ along / patch.width + 0.5
            y = off @ np.cross(along, normal) / patch.height + 0.5
            hit = (far > 1e-6) & (np.abs(x - 0.5) < 0.5) & (np.abs(y - 0.5) < 0.5)
        albedo = np.broadcast_to(np.array(patch.colour, np.float32), (int(hit.sum()), 3))
        if patch.picture is not None:
            albedo = _sampled(patch.picture, x[hit], y[hit])
        normals = np.where((rays[hit] @ normal > 0)[:, None], -normal, normal)
        self.put(window, hit, far[hit], number, self.shade(albedo, normals, rays[hit]))


def _sampled(picture: Image, x: FloatArray, y: FloatArray) -> NDArray[np.float32]:
    """Return colours of a picture between its pixels; x and y are 0 to 1."""
    height, width = picture.shape[:2]
    u = np.clip(x * width - 0.5, 0, width - 1.001)
    v = np.clip(y * height - 0.5, 0, height - 1.001)
    left, top = u.astype(int), v.astype(int)
    a, b = (u - left)[:, None], (v - top)[:, None]
    upper = (1 - a) * picture[top, left] + a * picture[top, left + 1]
    lower = (1 - a) * picture[top + 1, left] + a * picture[top + 1, left + 1]
    return np.asarray((1 - b) * upper + b * lower, np.float32)


@lru_cache(maxsize=3)
def _background(
    wall: Wall, look: Look, seed: int, camera: Camera, place: bytes
) -> tuple[FloatArray, NDArray[np.float32]]:
    """Return how far a wall is along every ray, and its colours: the same while a camera rests."""
    canvas = _Canvas(
        Scene(wall=None, look=look, seed=seed), camera, np.frombuffer(place).reshape(4, 4)
    )
    normal = np.array(wall.normal)
    rays = canvas.rays @ canvas.turn.T
    with np.errstate(divide="ignore", invalid="ignore"):
        far = ((np.array(wall.point) - canvas.origin) @ normal) / (rays @ normal)
    hit = far > 1e-6
    points = canvas.origin + far[hit][:, None] * rays[hit]
    colours = np.array(wall.colour, np.float32)
    albedo = colours * (1 + _WALL_TEXTURE * canvas.texture(points))[:, None]
    canvas.colour[hit] = canvas.shade(albedo, np.broadcast_to(normal, points.shape), rays[hit])
    return np.where(hit, far, np.inf), canvas.colour


def ellipsoid_hits(
    fruit: Fruit, origin: FloatArray, rays: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return how far along unit rays a fruit's surface is, and which of them hit it."""
    axis = np.array(fruit.axis)
    stretch = 1 / fruit.flattening - 1

    def round_again(vectors: FloatArray) -> FloatArray:
        return np.asarray(vectors + stretch * (vectors @ axis)[..., None] * axis)

    start = round_again(np.asarray(origin - np.array(fruit.centre)))
    ways = round_again(rays)
    a = np.einsum("...i,...i", ways, ways)
    b = ways @ start
    discriminant = b * b - a * (start @ start - fruit.radius**2)
    far = (-b - np.sqrt(np.clip(discriminant, 0, None))) / a
    return far, (discriminant > 0) & (far > 1e-6)


def render(
    scene: Scene,
    camera: Camera | None = None,
    *,
    pose: ArrayLike | None = None,
    frame: int = 0,
) -> Rendering:
    """Draw a scene, and say exactly what is where.

    Parameters
    ----------
    scene : Scene
        What there is.
    camera : Camera, optional
        Who looks; `paper_camera` by default.
    pose : array_like, shape (4, 4), optional
        Of the camera in the world; where the world's frame is, by default.
    frame : int, default 0
        Another number has other noise.

    Returns
    -------
    Rendering
        The same bits for the same arguments.

    Raises
    ------
    ArgumentError
        An argument is of another kind.
    MissingExtraError
        OpenCV is not installed (extra ``vision``).

    Examples
    --------
    >>> from agrik_fast.vision import random_scene, render
    >>> picture = render(random_scene("clean", seed=1))
    >>> picture.image.shape
    (240, 320, 3)
    """
    of_kind("scene", scene, Scene)
    camera = paper_camera() if camera is None else of_kind("camera", camera, Camera)
    frame = whole_number("frame", frame, 0)
    place = np.eye(4) if pose is None else finite_array("pose", pose, (4, 4))
    canvas = _Canvas(scene, camera, place)
    names = [f"fruit{i}" for i in range(len(scene.fruits))]
    for number, fruit in enumerate(scene.fruits):
        canvas.fruit(number, fruit)
    for number, leaf in enumerate(scene.leaves, len(names)):
        canvas.leaf(number, leaf)
    names += [f"leaf{i}" for i in range(len(scene.leaves))]
    for number, patch in enumerate(scene.patches, len(names)):
        canvas.patch(number, patch)
    names += [f"patch{i}" for i in range(len(scene.patches))]
    names.append("wall")
    depth, labels = _centres(canvas)
    return Rendering(
        _developed(canvas, frame),
        tuple(_truth(each, i, canvas) for i, each in enumerate(scene.fruits)),
        depth,
        labels,
        tuple(names),
    )


def _centres(canvas: _Canvas) -> tuple[FloatArray, NDArray[np.int32]]:
    """Return depth and label a pixel: of the farthest of its rays, which lies on one object."""
    z = canvas.far * canvas.rays[..., 2]
    blocks = (z.shape[0] // _SAMPLES, _SAMPLES, z.shape[1] // _SAMPLES, _SAMPLES)
    depth = z.reshape(blocks).transpose(0, 2, 1, 3).reshape(blocks[0], blocks[2], -1)
    label = canvas.label.reshape(blocks).transpose(0, 2, 1, 3).reshape(depth.shape)
    # What most rays see, the nearer of two: then the mean depth of those.
    nearest = np.take_along_axis(label, depth.argmin(axis=2)[..., None], axis=2)
    same = label == nearest
    with np.errstate(invalid="ignore"):
        mean = np.where(same, depth, 0).sum(axis=2) / same.sum(axis=2)
    return np.where(np.isfinite(mean), mean, np.nan), nearest[..., 0]


def _developed(canvas: _Canvas, frame: int) -> Image:
    """Return the picture: rays to pixels, blur, balance, light across it, noise."""
    cv2 = opencv()
    look, camera = canvas.scene.look, canvas.camera
    shape = (camera.height, _SAMPLES, camera.width, _SAMPLES, 3)
    picture = canvas.colour.reshape(shape).mean(axis=(1, 3), dtype=np.float32)
    if look.blur:
        picture = cv2.GaussianBlur(picture, (0, 0), look.blur)
    picture = picture * np.array(look.balance, np.float32) * np.float32(look.gain)
    if look.gradient:
        x = np.linspace(-1, 1, camera.width, dtype=np.float32) * math.cos(look.gradient_angle)
        y = np.linspace(-1, 1, camera.height, dtype=np.float32) * math.sin(look.gradient_angle)
        slope = (y[:, None] + x) / max(abs(x[0]) + abs(y[0]), 1e-6)
        picture = picture * (1 - look.gradient * (slope + 1) / 2)[..., None]
    rng = np.random.default_rng([31, canvas.scene.seed, frame])
    spread = np.sqrt(look.noise**2 + 0.05 * np.clip(picture, 0, 255))
    picture = picture + spread * rng.standard_normal(picture.shape, dtype=np.float32)
    return np.asarray(np.clip(np.rint(picture), 0, 255), np.uint8)


def _truth(fruit: Fruit, number: int, canvas: _Canvas) -> FruitTruth:
    centre = canvas.turn.T @ (np.array(fruit.centre) - canvas.origin)
    far = float(np.linalg.norm(centre))
    visible = 0.0
    if centre[2] > 0 and far > fruit.radius:
        rays = cone_rays(centre, fruit.radius * max(fruit.flattening, 1.0), 2000)
        _, hit = ellipsoid_hits(fruit, canvas.origin, rays @ canvas.turn.T)
        uv = canvas.camera.project(rays[hit])
        height, width = canvas.far.shape
        place = np.floor(_SAMPLES * (np.nan_to_num(uv, nan=-9.0) + 0.5)).astype(int)
        inside = (place >= 0).all(axis=1) & (place < [width, height]).all(axis=1)
        seen = canvas.label[place[inside, 1], place[inside, 0]] == number
        visible = float(seen.sum() / max(len(uv), 1))
    return FruitTruth(
        centre,
        fruit.radius,
        fruit.flattening,
        fruit.red,
        canvas.camera.project(centre),
        math.asin(min(fruit.radius / far, 1.0)),
        visible,
    )
