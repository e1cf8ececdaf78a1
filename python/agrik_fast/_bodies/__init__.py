"""What an arm's links and the things round it are made of; knows neither arms nor scenes."""

from ._shapes import LARGEST as LARGEST
from ._shapes import BodyShape, Box, Capsule, Convex, HalfSpace, Shape, Sphere
from ._shapes import point as point
from ._shapes import pose_of as pose_of

__all__ = ["BodyShape", "Box", "Capsule", "Convex", "HalfSpace", "Shape", "Sphere"]
