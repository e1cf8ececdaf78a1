"""From a camera's picture to a fruit an arm can point at, and to obstacles it must avoid.

Needs OpenCV (extra ``vision``). Pictures are uint8 arrays in the order blue, green, red; a camera
is any iterator of (time, picture). ``docs/vision.md`` says what was measured, and on what.
"""

from ._adapters import LongFruit, from_boxes, from_masks, long_fruit
from ._calibrate import Board, CameraCalibration, board_pose, calibrate
from ._camera import Camera, looking_at
from ._cone import Cone, cone_of_outline
from ._detect import Detector
from ._detection import Detection, DetectionStatus
from ._errors import CalibrationRefusedError, CameraError, VisionFileError
from ._hand_eye import CameraPose, eye_to_hand, hand_eye
from ._images import Image
from ._obstacles import Obstacle, balls_that_cover, fruit_radius, green_masks, obstacles
from ._photographs import Agreement, Photograph, agreement, photographs, read_boxes
from ._pictures import DETECTION_COLUMNS, annotated, detection_row, write_image
from ._plane import Plane, red_squares
from ._random_scenes import KINDS, random_scene
from ._range import Budget, StandOff, budget, range_sigma, stand_off
from ._red import red_mask
from ._render import FruitTruth, Rendering, render
from ._scenes import Fruit, Leaf, Look, Patch, Scene, Wall, paper_camera
from ._sources import Device, Frame, files, folder, folder_images, read_image, rendered
from ._stereo import StereoPair, Triangulated, triangulate
from ._track import Track, Tracker

__all__ = [
    "DETECTION_COLUMNS",
    "KINDS",
    "Agreement",
    "Board",
    "Budget",
    "CalibrationRefusedError",
    "Camera",
    "CameraCalibration",
    "CameraError",
    "CameraPose",
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
    "LongFruit",
    "Look",
    "Obstacle",
    "Patch",
    "Photograph",
    "Plane",
    "Rendering",
    "Scene",
    "StandOff",
    "StereoPair",
    "Track",
    "Tracker",
    "Triangulated",
    "VisionFileError",
    "Wall",
    "agreement",
    "annotated",
    "balls_that_cover",
    "board_pose",
    "budget",
    "calibrate",
    "cone_of_outline",
    "detection_row",
    "eye_to_hand",
    "files",
    "folder",
    "folder_images",
    "from_boxes",
    "from_masks",
    "fruit_radius",
    "green_masks",
    "hand_eye",
    "long_fruit",
    "looking_at",
    "obstacles",
    "paper_camera",
    "photographs",
    "random_scene",
    "range_sigma",
    "read_boxes",
    "read_image",
    "red_mask",
    "red_squares",
    "render",
    "rendered",
    "stand_off",
    "triangulate",
    "write_image",
]
