"""Print capsules that cover a link's meshes, as `[[collision]]` tables of a robot file.

    python tools/fit_capsules.py shoulder_link shoulder.stl "upper.stl 0 0 0.138 1.5708 0 -1.5708"

After the link's name each argument is a mesh file, with its place in the link's frame (m, rad) if
it is not there. Every triangle lies in one of the capsules whole. How far a capsule reaches out of
the meshes is measured from points on both.
"""

import argparse
import sys
from contextlib import suppress
from itertools import combinations
from pathlib import Path
from typing import TypeAlias

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.spatial import ConvexHull, KDTree, QhullError

Array = NDArray[np.float64]
Capsule: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float64], float]
"""Both ends and the radius, m."""
SHARES = (0.15, 0.3, 0.5, 0.7, 0.85)
"""Where a mesh is cut up at first, of its length."""
WORTH = 0.85
"""One capsule more is taken where all of them together then have so little of the volume."""
MOST = 3
POINTS = 6000
"""That measure a volume."""
EDGE = 0.04
"""Longest edge of a triangle, m."""
ROUND = 4
"""Digits of a metre; radii are rounded up."""


def main() -> int:
    """Fit and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("link")
    parser.add_argument("mesh", nargs="+")
    parser.add_argument("--mark", default="M", help="of the provenance (%(default)s)")
    parser.add_argument("--scale", type=float, default=1.0, help="m in a file's unit (%(default)s)")
    options = parser.parse_args()
    triangles = np.concatenate([triangles_of(mesh, options.scale) for mesh in options.mesh])
    sys.stdout.write(tables(options.link, triangles, options.mark))
    return 0


def triangles_of(argument: str, scale: float = 1.0) -> Array:
    """Return the triangles of a mesh (n, 3, 3) in the link's frame, m."""
    path, *numbers = argument.split()
    mesh = trimesh.load_mesh(Path(path))
    mesh.apply_scale(scale)
    pose = np.eye(4)
    if numbers:
        x, y, z, roll, pitch, yaw = (float(number) for number in numbers)
        pose = trimesh.transformations.euler_matrix(roll, pitch, yaw, "sxyz")
        pose[:3, 3] = x, y, z
    mesh.apply_transform(pose)
    # Triangles as long as a tube would tie both of its ends to one capsule.
    vertices, faces = trimesh.remesh.subdivide_to_size(mesh.vertices, mesh.faces, EDGE)
    return np.asarray(vertices[faces], dtype=float)


def tables(link: str, triangles: Array, mark: str) -> str:
    """Return the tables of the capsules that cover triangles."""
    written = []
    capsules = cover(triangles)
    for k, (a, b, radius) in enumerate(capsules):
        name = link if len(capsules) == 1 else f"{link}_{k + 1}"
        over = overestimate((a, b, radius), triangles)
        ends = "".join(
            f"{key}_m = {(np.round(p, ROUND) + 0.0).tolist()}\n" for key, p in (("a", a), ("b", b))
        )
        written.append(
            f'\n[[collision]]\nname = "{name}"\nframe = "{link}"\nshape = "capsule"\n{ends}'
            f"radius_m = {radius:.{ROUND}f}\noverestimate_m = {over:.3f}\n"
            f'provenance = {{ shape = "{mark}" }}\n'
        )
    return "".join(written)


def cover(triangles: Array) -> list[Capsule]:
    """Return as few capsules as are worth it."""
    found = [[fitted(triangles)]]
    for count in range(2, MOST + 1):
        cuts = combinations(SHARES, count - 1)
        tried = [split(triangles, cut, axis) for cut in cuts for axis in range(3)]
        best = min(tried, key=total)
        found.append([fitted(part) for part in parts(triangles, best)])
    return min(found, key=lambda capsules: total(capsules) / WORTH ** len(capsules))


def split(triangles: Array, cut: tuple[float, ...], axis: int) -> list[Capsule]:
    """Cover triangles by capsules, first cut up at shares of one of their principal axes."""
    centres = triangles.mean(axis=1)
    along = (centres - centres.mean(axis=0)) @ principal(triangles.reshape(-1, 3))[axis]
    edges = along.min() + np.array(cut) * np.ptp(along)
    part = np.searchsorted(edges, along)
    capsules: list[Capsule] = []
    for _ in range(20):
        pieces = [triangles[part == k] for k in np.unique(part)]
        capsules = [rough(piece.reshape(-1, 3)) for piece in pieces]
        moved = nearest(triangles, capsules)
        if (moved == part).all():
            break
        part = moved
    return capsules


def parts(triangles: Array, capsules: list[Capsule]) -> list[Array]:
    """Return the triangles of each capsule."""
    part = nearest(triangles, capsules)
    return [triangles[part == k] for k in np.unique(part)]


def nearest(triangles: Array, capsules: list[Capsule]) -> NDArray[np.int64]:
    """Return which capsule each triangle reaches out of least."""
    outside = [
        distances(triangles.reshape(-1, 3), a, b).reshape(-1, 3).max(axis=1) - radius
        for a, b, radius in capsules
    ]
    return np.argmin(outside, axis=0)


def total(capsules: list[Capsule]) -> float:
    """Return the volume of the union, m^3: the share of points in the box round it."""
    low = np.min([np.minimum(a, b) - radius for a, b, radius in capsules], axis=0)
    high = np.max([np.maximum(a, b) + radius for a, b, radius in capsules], axis=0)
    points = low + np.random.default_rng(1).random((POINTS, 3)) * (high - low)
    inside = [distances(points, a, b) <= radius for a, b, radius in capsules]
    return float(np.mean(np.any(inside, axis=0)) * np.prod(high - low))


def volume(length: float, radius: float) -> float:
    """Return the volume of a capsule, m^3."""
    return np.pi * radius**2 * (length + 4 / 3 * radius)


def principal(points: Array) -> Array:
    """Return the principal axes of points as rows."""
    return np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]


def rough(points: Array) -> Capsule:
    """Return the smallest capsule along a principal axis of points that is as long as they are."""
    found = []
    for axis in principal(points):
        along = points @ axis
        off = points - along[:, None] * axis
        middle = 0.5 * (off.min(axis=0) + off.max(axis=0))
        radius = float(np.linalg.norm(off - middle, axis=1).max())
        low, high = along.min() + radius, along.max() - radius
        if low > high:
            low = high = 0.5 * (low + high)
        a, b = middle + low * axis, middle + high * axis
        found.append((a, b, float(distances(points, a, b).max())))
    return min(found, key=lambda of: volume(float(np.linalg.norm(of[1] - of[0])), of[2]))


def fitted(triangles: Array) -> Capsule:
    """Return a small capsule round triangles, rounded outwards."""
    points = np.unique(triangles.reshape(-1, 3), axis=0)
    with suppress(QhullError):  # Flat ones have no hull: all of their points do.
        points = points[ConvexHull(points).vertices]

    def cost(ends: Array) -> float:
        a, b = ends[:3], ends[3:]
        return volume(float(np.linalg.norm(b - a)), float(distances(points, a, b).max()))

    start, end, _ = rough(points)
    from_there = np.concatenate([start, end])
    best = minimize(cost, from_there, method="Powell", options={"maxiter": 30, "xtol": 1e-4})
    better = best.x if best.fun < cost(from_there) else from_there
    ends = np.round(better, ROUND)
    a, b = ends[:3], ends[3:]
    radius = float(distances(triangles.reshape(-1, 3), a, b).max())
    return a, b, float(np.ceil(radius * 10**ROUND) / 10**ROUND)


def distances(points: Array, a: Array, b: Array) -> Array:
    """Return the distances of points from a segment."""
    along = b - a
    length = float(along @ along)
    at = np.zeros(len(points)) if length == 0 else np.clip((points - a) @ along / length, 0, 1)
    return np.linalg.norm(points - a - at[:, None] * along, axis=1)


def overestimate(capsule: Capsule, triangles: Array) -> float:
    """Return how far points of a capsule's surface are from the meshes at most, m, rounded up."""
    a, b, radius = capsule
    rng = np.random.default_rng(1)
    # Points all over the triangles, by area.
    edges = triangles[:, 1:] - triangles[:, :1]
    area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    chosen = rng.choice(len(triangles), 40_000, p=area / area.sum())
    u, v = rng.random((2, len(chosen), 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    on_mesh = triangles[chosen, 0] + u * edges[chosen, 0] + v * edges[chosen, 1]
    way = rng.normal(size=(4000, 3))
    way /= np.linalg.norm(way, axis=1)[:, None]
    axis = b - a
    at = np.where((way @ axis)[:, None] > 0, b, a)
    side = np.cross(way, axis) if np.linalg.norm(axis) > 0 else way
    side /= np.linalg.norm(side, axis=1)[:, None]
    surface = np.concatenate([at + radius * way, a + rng.random((4000, 1)) * axis + radius * side])
    return float(np.ceil(KDTree(on_mesh).query(surface)[0].max() * 1000) / 1000)


if __name__ == "__main__":
    sys.exit(main())
