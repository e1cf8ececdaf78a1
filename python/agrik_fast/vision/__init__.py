"""From a camera's picture to a fruit an arm can point at, and to obstacles it must avoid.

Needs OpenCV (extra ``vision``). Pictures are uint8 arrays in the order blue, green, red; a camera
is any iterator of (time, picture). ``docs/vision.md`` says what was measured, and on what.
"""

from ._camera import Camera, looking_at
from ._cone import Cone, cone_of_outline
from ._detect import Detection, DetectionStatus, Detector, red_mask
from ._errors import CalibrationRefusedError, CameraError, VisionFileError
from ._images import Image
from ._pictures import DETECTION_COLUMNS, annotated, detection_row, write_image
from ._plane import Plane, red_squares
from ._random_scenes import KINDS, random_scene
from ._range import Budget, StandOff, budget, range_sigma, stand_off
from ._render import FruitTruth, Rendering, render
from ._scenes import Fruit, Leaf, Look, Scene, Wall, paper_camera
from ._sources import Device, Frame, files, folder, folder_images, read_image, rendered
from ._track import Track, Tracker

__all__ = [
    "DETECTION_COLUMNS",
    "KINDS",
    "Budget",
    "CalibrationRefusedError",
    "Camera",
    "CameraError",
    "Cone",
    "Detection",
    "DetectionStatus",
    "Detector",
    "Device",
    "Frame",
    "Fruit",
    "FruitTruth",
    "Image",
    "Leaf",
    "Look",
    "Plane",
    "Rendering",
    "Scene",
    "StandOff",
    "Track",
    "Tracker",
    "VisionFileError",
    "Wall",
    "annotated",
    "budget",
    "cone_of_outline",
    "detection_row",
    "files",
    "folder",
    "folder_images",
    "looking_at",
    "paper_camera",
    "random_scene",
    "range_sigma",
    "read_image",
    "red_mask",
    "red_squares",
    "render",
    "rendered",
    "stand_off",
    "write_image",
]
