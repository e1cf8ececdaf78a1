"""What stands round an arm, and how near the arm comes to it."""

from .._bodies import (
    Body,
    BodyShape,
    Box,
    Capsule,
    CollisionRules,
    Convex,
    Cover,
    ExcludedPair,
    HalfSpace,
    SelfPairs,
    Sphere,
)
from ._clouds import Cloud, objects_of, read_cloud
from ._content import Target
from ._crop import fruit, leaf, pipe, row, stalk, stem, wire
from ._files import file_schema
from ._greenhouse import greenhouse, greenhouse_document
from ._objects import SceneObject
from ._queries import Distances
from ._scene import Scene, document_of, from_document

__all__ = [
    "Body",
    "BodyShape",
    "Box",
    "Capsule",
    "Cloud",
    "CollisionRules",
    "Convex",
    "Cover",
    "Distances",
    "ExcludedPair",
    "HalfSpace",
    "Scene",
    "SceneObject",
    "SelfPairs",
    "Sphere",
    "Target",
    "document_of",
    "file_schema",
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
