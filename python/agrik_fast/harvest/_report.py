"""An evaluation as files: a table, a record and pictures."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .. import _native
from .._atomic import write_bytes
from .._checks import shown, truth_value
from ..errors import AgrikError, ArgumentError
from ._evaluate import Evaluation

__all__ = ["summary", "write_report"]


def summary(found: Evaluation) -> dict[str, Any]:
    """Return the record of an evaluation: shares, leaves in the way, settings, targets.

    Parameters
    ----------
    found : Evaluation

    Returns
    -------
    dict
        What `write_report` writes as JSON; lengths in the unit that a name says.

    Examples
    --------
    >>> found = ik.harvest.evaluate(ik.harvest.example_scene())
    >>> "shares" in ik.harvest.summary(found)
    True
    """
    if not isinstance(found, Evaluation):
        raise ArgumentError("found", shown(found), "an Evaluation")
    return {
        "format": 1,
        "version": _native.__version__,
        "robot": found.robot.name,
        "distance": found.distance,
        "settings": found.settings.as_options(),
        "fruits": len(found.decisions),
        "share_ok": found.share,
        "shares": found.shares(),
        "statuses": found.decisions.shares(),
        "blocked_by": dict(found.leaves()),
        "seconds": found.seconds,
        "targets": list(found.rows()),
    }


def write_report(
    found: Evaluation,
    directory: Path,
    *,
    pictures: bool = True,
    report: Callable[[str], object] | None = None,
) -> list[Path]:
    """Write an evaluation into a folder: ``harvest.csv``, ``harvest.json`` and pictures.

    Parameters
    ----------
    found : Evaluation
    directory : path
        Made if it does not exist; files of these names are replaced.
    pictures : bool, default True
        Draw them too; needs Matplotlib.
    report : callable, optional
        Called with a line on what is being done.

    Returns
    -------
    list of Path

    Raises
    ------
    AgrikError
        A file cannot be written, or Matplotlib is missing.

    Examples
    --------
    >>> import pathlib
    >>> found = ik.harvest.evaluate(ik.harvest.example_scene())
    >>> files = ik.harvest.write_report(found, pathlib.Path("harvest"), pictures=False)
    >>> [file.name for file in files]
    ['harvest.csv', 'harvest.json']
    """
    record = summary(found)
    truth_value("pictures", pictures)
    directory.mkdir(parents=True, exist_ok=True)
    files = [
        _write(directory / "harvest.csv", _table(record["targets"])),
        _write(directory / "harvest.json", (json.dumps(record, indent=1) + "\n").encode()),
    ]
    if pictures:
        from ._pictures import status_pictures

        for name, drawing in status_pictures(found).items():
            if report is not None:
                report(f"picture {name}")
            stream = io.BytesIO()
            drawing.savefig(stream, format="png", dpi=130, metadata={"Software": None})
            files.append(_write(directory / f"{name}.png", stream.getvalue()))
    return files


def _table(rows: list[dict[str, Any]]) -> bytes:
    columns: dict[str, None] = {}
    for row in rows:
        columns.update(dict.fromkeys(row))
    stream = io.StringIO(newline="")
    writer = csv.DictWriter(stream, list(columns), restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return stream.getvalue().encode()


def _write(path: Path, data: bytes) -> Path:
    write_bytes(path, data, lambda reason: AgrikError(f"{path}: {reason}"), force=True)
    return path
