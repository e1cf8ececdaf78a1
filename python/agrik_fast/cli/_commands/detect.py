"""Fruits in pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .._exits import exit_codes, say, telling


def detect(
    images: Annotated[list[Path], typer.Argument(help="Pictures, or folders of them.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the files.")],
    calibration: Annotated[
        Path | None,
        typer.Option("--calibration", help="The camera's file (.json); for pictures of its size."),
    ] = None,
    view_deg: Annotated[
        float,
        typer.Option(
            help="Without a calibration: how wide the camera sees, degrees.", min=1, max=170
        ),
    ] = 60.0,
    radius_mm: Annotated[
        float | None, typer.Option(help="The fruits' radius, mm: places then are in the table.")
    ] = None,
    boxes: Annotated[
        Path | None,
        typer.Option(
            help="Boxes that you marked (.csv: image,left,top,right,bottom in pixels): says how "
            "many were found."
        ),
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Write into a folder that holds files.")
    ] = False,
) -> None:
    """Find ripe tomatoes in pictures, draw them and write a table.

    Writes detections.csv (one row a fruit: status, place and half angle; not_found for a picture
    without any) and every picture with what was found. Only status ok is fit to be approached.
    Needs the extra `vision`.
    """
    with exit_codes() as kept:
        from .._detect import DetectRequest
        from .._detect import detect as look

        kept.what = lambda: f"pictures that were finished are in {output}"
        request = DetectRequest(images, output, calibration, view_deg, radius_mm, boxes, force)
        files = look(request, say)
        with telling(f"files: {output}"):
            for file in files:
                typer.echo(str(file))
