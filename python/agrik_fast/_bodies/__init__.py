"""What an arm's links and the things round it are made of; knows neither arms nor scenes.

What only URDFs, pictures and viewers need is loaded when it is first used: the first answer of a
robot is not to wait for it.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ._body import Body, CollisionRules, ExcludedPair, SelfPairs
from ._shapes import LARGEST as LARGEST
from ._shapes import SPLITS as SPLITS
from ._shapes import BodyShape, Box, Capsule, Convex, Cover, HalfSpace, Shape, Sphere
from ._shapes import Rows as Rows
from ._shapes import point as point
from ._shapes import pose_of as pose_of

if TYPE_CHECKING:
    from ._surfaces import Triangles as Triangles
    from ._surfaces import box as box
    from ._surfaces import cylinder as cylinder
    from ._surfaces import surface as surface
    from ._urdf import CYLINDERS as CYLINDERS
    from ._urdf import MESHES as MESHES
    from ._urdf import UrdfGeometry as UrdfGeometry
    from ._urdf import mesh_places as mesh_places
    from ._visuals import Visual as Visual
    from ._visuals import has_visuals as has_visuals
    from ._visuals import visuals as visuals

__all__ = [
    "Body",
    "BodyShape",
    "Box",
    "Capsule",
    "CollisionRules",
    "Convex",
    "Cover",
    "ExcludedPair",
    "HalfSpace",
    "SelfPairs",
    "Shape",
    "Sphere",
]

_LATER = {
    "_surfaces": ("Triangles", "box", "cylinder", "surface"),
    "_urdf": ("CYLINDERS", "MESHES", "UrdfGeometry", "mesh_places"),
    "_visuals": ("Visual", "has_visuals", "visuals"),
}
_MODULE_OF = {name: module for module, names in _LATER.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
