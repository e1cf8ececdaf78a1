"""What goes wrong with pictures, cameras and calibrations."""

from __future__ import annotations

from ..errors import AgrikError

__all__ = ["CalibrationRefusedError", "CameraError", "VisionFileError"]


class CameraError(AgrikError, RuntimeError):
    """A camera delivers nothing, stalls, or cannot be opened.

    Parameters
    ----------
    camera : str
        Which: a file's or folder's name, or the number of a device.
    reason : str
        What is wrong.

    Attributes
    ----------
    camera, reason
        The parameters.

    Examples
    --------
    >>> from agrik_fast.vision import CameraError
    >>> issubclass(CameraError, ik.AgrikError)
    True
    """

    camera: str
    reason: str

    def __init__(self, camera: str, reason: str) -> None:
        self.camera = camera
        self.reason = reason
        super().__init__(f"camera {camera}: {reason}")

    def __reduce__(self) -> tuple[type[CameraError], tuple[str, str]]:
        return type(self), (self.camera, self.reason)


class CalibrationRefusedError(AgrikError, ValueError):
    """Views, poses or points do not determine what is to be calibrated.

    Examples
    --------
    >>> from agrik_fast.vision import CalibrationRefusedError
    >>> issubclass(CalibrationRefusedError, ik.AgrikError)
    True
    """


class VisionFileError(AgrikError, ValueError):
    """A camera's file, a table of pixels or a picture cannot be read.

    Parameters
    ----------
    file : str
        Its name.
    reason : str
        What is wrong, and where in the file.

    Attributes
    ----------
    file, reason
        The parameters.

    Examples
    --------
    >>> from agrik_fast.vision import VisionFileError, read_image
    >>> try:
    ...     read_image("nowhere.png")
    ... except VisionFileError as error:
    ...     print(type(error).__name__)
    VisionFileError
    """

    file: str
    reason: str

    def __init__(self, file: str, reason: str) -> None:
        self.file = file
        self.reason = reason
        super().__init__(f"{file}: {reason}")

    def __reduce__(self) -> tuple[type[VisionFileError], tuple[str, str]]:
        return type(self), (self.file, self.reason)
