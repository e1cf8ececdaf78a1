"""JSON Schemas of the package's kinds of files."""

from __future__ import annotations

import json

from .._checks import word
from ..robot import file_schema
from ..solvers.gain_file import GainFile


def json_schema(kind: str) -> str:
    """Return the JSON Schema of a kind of file.

    Raises
    ------
    UnknownNameError
        There is no such kind.
    """
    makers = {"robot": file_schema, "gains": GainFile.model_json_schema}
    return json.dumps(makers[word("kind of file", kind, makers)](), indent=2)
