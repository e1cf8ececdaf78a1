"""The made-up rows of cucumbers that come with the package."""

from __future__ import annotations

from importlib.resources import files

from .._checks import word
from ..collision import Scene, from_document

__all__ = ["SCENES", "example_scene"]

SCENES = ("cucumber", "cucumber_thin")
"""A row of four fruits among twelve leaves, and one thinned out to a single fruit."""


def example_scene(name: str = "cucumber") -> Scene:
    """Return a made-up scene that comes with the package.

    Parameters
    ----------
    name : {"cucumber", "cucumber_thin"}, default "cucumber"
        A row of four fruits among twelve leaves, 671 points, with two more targets that are out
        of reach; or one fruit among four leaves.

    Returns
    -------
    Scene
        In metres, world frame of the robot "cucumber": x to the crop, y along the row, z up.

    Raises
    ------
    UnknownNameError
        Another name.

    Examples
    --------
    >>> sorted(ik.harvest.example_scene().targets)[:2]
    ['C1', 'C2']
    """
    import json

    word("scene", name, SCENES)
    file = files(__package__).joinpath("bundled", f"{name}.json")
    return from_document(json.loads(file.read_text("utf-8")), name=f"{name}.json")
