"""Mesh files of a URDF: where they are looked for, and the convex hulls of what they hold."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .._checks import FloatArray
from .._files import brief, os_reason
from ..errors import UrdfError

_MESH_BYTES = 512 << 20
_TRIANGLES = 5_000_000


@dataclass(frozen=True)
class MeshPlaces:
    """Where mesh files may be.

    Attributes
    ----------
    folder : path or None
        That of the URDF; None if it came as text.
    given : tuple of path
        Folders that the caller named; those of packages are in them.
    """

    folder: Path | None = None
    given: tuple[Path, ...] = ()

    def find(self, link: str, name: str) -> Path:
        """Return the file that a URDF calls `name`.

        Raises
        ------
        UrdfError
            It is nowhere; names the link, the file and the places.
        """
        places = list(dict.fromkeys(self._candidates(name)))
        for place in places:
            if place.is_file():
                return place
        looked = ", ".join(map(str, places)) or "nowhere: the URDF came as text, and no folder " \
            "of meshes was given (`mesh_folders`)"  # fmt: skip
        raise UrdfError(f"link {link!r}: mesh file {name!r} is missing; looked for at {looked}")

    def _candidates(self, name: str) -> Iterator[Path]:
        from urllib.parse import unquote, urlparse

        parsed = urlparse(name)
        if parsed.scheme == "package":
            package, inside = parsed.netloc, unquote(parsed.path).lstrip("/")
            yield from self._in_packages(package, inside)
            return
        plain = unquote(parsed.netloc + parsed.path) if parsed.scheme == "file" else name
        if Path(plain).is_absolute():
            yield Path(plain)
            return
        for folder in (*self.given, *(() if self.folder is None else (self.folder,))):
            yield folder / plain

    def _in_packages(self, package: str, inside: str) -> Iterator[Path]:
        for folder in self.given:
            yield folder / package / inside
            yield folder / inside
        above = () if self.folder is None else (self.folder, *self.folder.parents)
        for folder in above:
            if folder.name == package:
                yield folder / inside
            yield folder / package / inside
        for variable, middle in (("ROS_PACKAGE_PATH", ""), ("AMENT_PREFIX_PATH", "share")):
            for one in os.environ.get(variable, "").split(os.pathsep):
                if one:
                    yield Path(one) / middle / package / inside


def triangles_of(link: str, file: Path) -> list[FloatArray]:
    """Return the triangles of each mesh in a file, shape (m, 3, 3), m before a URDF's scale.

    Raises
    ------
    UrdfError
        trimesh is not installed, or the file cannot be read; names the link and the file.
    """
    try:
        import trimesh
    except ImportError:
        raise UrdfError(
            f"link {link!r}: reading {str(file)!r} needs trimesh and SciPy; install "
            "agrik_fast[meshes]"
        ) from None

    def refuse(reason: str) -> UrdfError:
        return UrdfError(f"link {link!r}: mesh file {str(file)!r} {reason}")

    if file.stat().st_size > _MESH_BYTES:
        raise refuse(f"is longer than {_MESH_BYTES} bytes")
    try:
        meshes = [
            np.asarray(one.triangles, dtype=np.float64) * _metres(trimesh, one)
            for one in trimesh.load_scene(file, process=False).dump()
            if hasattr(one, "triangles") and len(one.triangles)
        ]
    except OSError as error:
        reason = os_reason(error) if error.errno is not None else brief(error)
        raise refuse(f"cannot be read: {reason}") from error
    except MemoryError:
        raise
    except Exception as error:  # whatever the readers of a dozen formats raise
        raise refuse(f"cannot be read: {brief(error)}") from error
    if not meshes:
        raise refuse("cannot be read: it holds no triangles, or ends early")
    if sum(map(len, meshes)) > _TRIANGLES:
        raise refuse(f"holds more than {_TRIANGLES} triangles")
    if not all(np.isfinite(one).all() for one in meshes):
        raise refuse("holds corners that are not finite")
    return meshes


def _metres(trimesh: Any, mesh: Any) -> float:
    """Return the unit of a mesh, m; of formats that have none, 1: a URDF's scale is for those."""
    return 1.0 if mesh.units is None else float(trimesh.units.unit_conversion(mesh.units, "meters"))
