"""A camera's calibration by pictures of a ChArUco board, checked on views that were held back."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks import FloatArray, items, real_number, whole_number
from ..errors import ArgumentError
from ._camera import Camera
from ._cv import opencv
from ._errors import CalibrationRefusedError
from ._images import Image, checked_image, of_kind, same_size

__all__ = ["Board", "CameraCalibration", "board_pose", "calibrate"]

FEWEST_CORNERS = 8
FEWEST_VIEWS = 8
_HELD_BACK = 5


@dataclass(frozen=True)
class Board:
    """A ChArUco board of the dictionary 4x4_50.

    Parameters
    ----------
    columns, rows : int, default 7 and 5
        Squares.
    square, marker : float, default 0.030 and 0.022, m
        Sides of a square and of the marker in it.

    Examples
    --------
    >>> from agrik_fast.vision import Board
    >>> Board(columns=7, rows=5).square
    0.03
    """

    columns: int = 7
    rows: int = 5
    square: float = 0.030
    marker: float = 0.022

    def __post_init__(self) -> None:
        for name in ("columns", "rows"):
            whole_number(f"Board.{name}", getattr(self, name), 3, 14)
        square = real_number("Board.square", self.square, 0, open_low=True, unit="m")
        marker = real_number("Board.marker", self.marker, 0, open_low=True, unit="m")
        if marker >= square:
            raise ArgumentError(
                "Board.marker", f"{marker:g}", f"less than the square, {square:g} m"
            )
        if self.columns * self.rows // 2 > 50:
            raise ArgumentError("Board.columns", f"{self.columns} x {self.rows}", "50 markers")

    def made(self) -> Any:
        """Return OpenCV's board.

        Examples
        --------
        >>> from agrik_fast.vision import Board
        >>> Board().made().getChessboardSize()
        (7, 5)
        """
        aruco = opencv().aruco
        dictionary = aruco.getPredefinedDictionary(aruco.DICT_4X4_50)
        return aruco.CharucoBoard((self.columns, self.rows), self.square, self.marker, dictionary)

    def picture(self, pixels: int = 60) -> Image:
        """Return the board to be printed, with so many pixels to a square and no margin.

        Examples
        --------
        >>> from agrik_fast.vision import Board
        >>> Board().picture(20).shape
        (100, 140, 3)
        """
        pixels = whole_number("pixels", pixels, 10, 2000)
        grey = self.made().generateImage((self.columns * pixels, self.rows * pixels))
        return np.ascontiguousarray(np.repeat(grey[..., None], 3, axis=2))


@dataclass(frozen=True)
class CameraCalibration:
    """A camera, and how well it was calibrated.

    Attributes
    ----------
    camera : Camera
        The result.
    rms : float, pixels
        Of the corners that it was fitted to. A small one proves nothing.
    held_back_rms, held_back_max : float, pixels
        Of the corners in views that it was not fitted to.
    used, held_back, skipped : tuple of int
        Numbers of the views; skipped are those with fewer than 8 corners.

    Examples
    --------
    >>> from agrik_fast.vision import CameraCalibration, paper_camera
    >>> found = CameraCalibration(paper_camera(), 0.2, 0.2, 0.6, (0, 1), (2,), ())
    >>> found.rms
    0.2
    """

    camera: Camera
    rms: float
    held_back_rms: float
    held_back_max: float
    used: tuple[int, ...]
    held_back: tuple[int, ...]
    skipped: tuple[int, ...]


def _corners(image: Image, board: Board) -> tuple[NDArray[Any], NDArray[Any]] | None:
    """Return corners on the board (m) and in the picture, or None where there are too few."""
    cv2 = opencv()
    made = board.made()
    corners, ids, _, _ = cv2.aruco.CharucoDetector(made).detectBoard(image)
    if ids is None or len(ids) < FEWEST_CORNERS:
        return None
    on_board, in_picture = made.matchImagePoints(corners, ids)
    return on_board.reshape(-1, 3), in_picture.reshape(-1, 2)


def calibrate(images: Iterable[Image], board: Board | None = None) -> CameraCalibration:
    """Calibrate a camera by pictures of a board, every fifth of them held back as a check.

    18 views at 0.2 to 0.32 m, tilted by up to 35 degrees, with corners near the picture's own
    corners, are enough. Calibrate at 640 x 480 and scale down (`Camera.scaled`). k3 stays 0.

    Parameters
    ----------
    images : iterable of ndarray
        All of one size.
    board : Board, optional
        What they show.

    Raises
    ------
    ArgumentError
        One is no picture, or of another size than the first.
    CalibrationRefusedError
        Fewer than 8 views with 8 corners or more, beside those that are held back.

    Examples
    --------
    >>> from agrik_fast.vision import CalibrationRefusedError, calibrate
    >>> try:
    ...     calibrate([])
    ... except CalibrationRefusedError as error:
    ...     print(type(error).__name__)
    CalibrationRefusedError
    """
    cv2 = opencv()
    board = Board() if board is None else of_kind("board", board, Board)
    views: list[tuple[int, NDArray[Any], NDArray[Any]]] = []
    skipped: list[int] = []
    size: tuple[int, int] | None = None
    for number, each in enumerate(items("images", images, "pictures")):
        image = checked_image(f"images[{number}]", each)
        if size is None:
            size = image.shape[1], image.shape[0]
        same_size(f"images[{number}]", image, *size)
        found = _corners(image, board)
        if found is None:
            skipped.append(number)
        else:
            views.append((number, *found))
    checks = views[_HELD_BACK - 1 :: _HELD_BACK] if len(views) >= FEWEST_VIEWS + 2 else []
    fitted = [view for view in views if all(view is not check for check in checks)]
    if size is None or len(fitted) < FEWEST_VIEWS:
        raise CalibrationRefusedError(
            f"{len(fitted)} views show {FEWEST_CORNERS} corners or more, "
            f"{FEWEST_VIEWS} are needed ({len(skipped)} were skipped)"
        )
    rms, matrix, distortion, _, _ = cv2.calibrateCamera(
        [view[1] for view in fitted],
        [view[2] for view in fitted],
        size,
        None,
        None,
        flags=cv2.CALIB_FIX_K3,
    )
    five = np.zeros(5)
    flat = np.ravel(distortion)[:5]
    five[: len(flat)] = flat
    if not (np.isfinite(matrix).all() and np.isfinite(five).all()):
        raise CalibrationRefusedError("the views do not determine a camera")
    matrix[0, 1] = 0.0
    camera = Camera.from_matrix(*size, matrix, five)
    off = [_off(camera, view[1], view[2]) for view in checks]
    squares = np.concatenate(off) ** 2 if off else np.full(1, np.nan)
    return CameraCalibration(
        camera,
        float(rms),
        float(np.sqrt(squares.mean())),
        float(np.sqrt(squares.max())),
        tuple(view[0] for view in fitted),
        tuple(view[0] for view in checks),
        tuple(skipped),
    )


def _solved(camera: Camera, points: NDArray[Any], pixels: NDArray[Any]) -> FloatArray | None:
    """Return the pose of a plane of points in the camera's frame."""
    cv2 = opencv()
    good, turn, place = cv2.solvePnP(
        points, pixels, camera.matrix, np.array(camera.distortion), flags=cv2.SOLVEPNP_ITERATIVE
    )
    if not good or not (np.isfinite(turn).all() and np.isfinite(place).all()):
        return None
    pose = np.eye(4)
    pose[:3, :3] = cv2.Rodrigues(turn)[0]
    pose[:3, 3] = np.ravel(place)
    return pose


def _off(camera: Camera, points: NDArray[Any], pixels: NDArray[Any]) -> FloatArray:
    pose = _solved(camera, points, pixels)
    if pose is None:
        return np.full(1, np.inf)
    seen = camera.project(points @ pose[:3, :3].T + pose[:3, 3])
    return np.asarray(np.linalg.norm(seen - pixels, axis=1))


def board_pose(image: Image, camera: Camera, board: Board | None = None) -> FloatArray:
    """Return where a board is, shape (4, 4), in the camera's frame.

    Parameters
    ----------
    image : ndarray
        A picture of the calibration's size.
    camera : Camera
        Who took it.
    board : Board, optional
        What it shows.

    Raises
    ------
    ArgumentError
        It is no picture of this camera.
    CalibrationRefusedError
        Fewer than 8 corners are seen.

    Examples
    --------
    >>> from agrik_fast.vision import Board, Camera, board_pose
    >>> camera, board = Camera.of_view(640, 480, 60.0), Board()
    >>> picture = np.full((480, 640, 3), 128, dtype=np.uint8)
    >>> printed = board.picture(60)
    >>> picture[60 : 60 + printed.shape[0], 90 : 90 + printed.shape[1]] = printed
    >>> board_pose(picture, camera, board).shape
    (4, 4)
    """
    picture = checked_image("image", image)
    of_kind("camera", camera, Camera)
    same_size("image", picture, camera.width, camera.height)
    found = _corners(picture, Board() if board is None else of_kind("board", board, Board))
    pose = None if found is None else _solved(camera, *found)
    if pose is None:
        raise CalibrationRefusedError(f"fewer than {FEWEST_CORNERS} corners of the board are seen")
    return pose
