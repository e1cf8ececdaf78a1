"""What stands round an arm, and how near the arm comes to it."""

from .._bodies import Box, Capsule, Convex, HalfSpace, Sphere
from ._clouds import Cloud, objects_of, read_cloud
from ._crop import fruit, leaf, pipe, row, stalk, stem, wire
from ._files import document_of, from_document
from ._greenhouse import greenhouse, greenhouse_document
from ._objects import SceneObject
from ._scene import Scene, Target

__all__ = [
    "Box",
    "Capsule",
    "Cloud",
    "Convex",
    "HalfSpace",
    "Scene",
    "SceneObject",
    "Sphere",
    "Target",
    "document_of",
    "from_document",
    "fruit",
    "greenhouse",
    "greenhouse_document",
    "leaf",
    "objects_of",
    "pipe",
    "read_cloud",
    "row",
    "stalk",
    "stem",
    "wire",
]
