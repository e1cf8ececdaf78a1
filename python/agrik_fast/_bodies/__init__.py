"""What an arm's links and the things round it are made of; knows neither arms nor scenes."""

from ._body import Body, CollisionRules, ExcludedPair, SelfPairs
from ._shapes import LARGEST as LARGEST
from ._shapes import SPLITS as SPLITS
from ._shapes import BodyShape, Box, Capsule, Convex, Cover, HalfSpace, Shape, Sphere
from ._shapes import Rows as Rows
from ._shapes import point as point
from ._shapes import pose_of as pose_of
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
