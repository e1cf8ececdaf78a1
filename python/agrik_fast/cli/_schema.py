"""JSON Schemas of the package's kinds of files."""

from __future__ import annotations

import json
from typing import Any

from .._checks import word
from ..robot import file_schema
from ..solvers.gain_file import GainFile

KINDS = ("robot", "gains", "scene", "calibration")
"""Kinds of files that have one."""
# What pydantic's schemas are written in.
_DIALECT = "https://json-schema.org/draft/2020-12/schema"


def json_schema(kind: str) -> str:
    """Return the JSON Schema of a kind of file.

    Raises
    ------
    UnknownNameError
        There is no such kind.
    """
    schema = _schema(word("kind of file", kind, KINDS))
    return json.dumps({"$schema": _DIALECT, **schema}, indent=2)


def _schema(kind: str) -> dict[str, Any]:
    if kind == "robot":
        return file_schema()
    if kind == "gains":
        return GainFile.model_json_schema()
    if kind == "scene":
        from ..collision import file_schema as scene_schema

        return scene_schema()
    from ..drivers import Calibration

    return Calibration.model_json_schema()
