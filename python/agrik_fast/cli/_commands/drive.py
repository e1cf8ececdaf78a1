"""Motors and their firmware."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .._exits import exit_codes, telling


def drive(
    rig: Annotated[str, typer.Argument(help="strawberry or tomato.")],
    targets: Annotated[
        Path | None,
        typer.Option(
            help="Points: .csv, .npy, .npz or .parquet; columns x,y,z without a unit are mm."
        ),
    ] = None,
    port: Annotated[
        str,
        typer.Option(
            help="simulated (the firmware in a simulator), or what pyserial takes: /dev/ttyACM0, "
            "COM3, socket://host:port."
        ),
    ] = "simulated",
    calibration: Annotated[
        Path | None, typer.Option(help="Calibration file; the bundled one by default.")
    ] = None,
    method: Annotated[
        str, typer.Option(help="Strawberry: exact, as, ssas or ncos, for the joint values.")
    ] = "exact",
    psi: Annotated[float, typer.Option(help="Strawberry: turn of the gripper in degrees.")] = 0.0,
    h_extra: Annotated[
        float | None,
        typer.Option(
            help="Strawberry: how far above its end the arm waits, in mm; by default 30, or as "
            "much more as keeps it clear of the plant."
        ),
    ] = None,
    near: Annotated[
        bool, typer.Option("--near", help="Tomato: slowly, 60 instead of 200 degrees/s.")
    ] = False,
    log: Annotated[
        Path | None, typer.Option(help="File that every frame on the line is written to.")
    ] = None,
    camera: Annotated[
        str | None,
        typer.Option(
            help="Tomato, instead of --targets: a camera that finds them. simulated (the renderer, "
            "with --port simulated), the number of a device, a video, or a folder of pictures."
        ),
    ] = None,
    camera_calibration: Annotated[
        Path | None, typer.Option(help="The camera's file (.json), as `vision.Camera.save` writes.")
    ] = None,
    camera_pose: Annotated[
        Path | None,
        typer.Option(help="The camera's pose in the arm's frame: .json, a matrix of 4 x 4, m."),
    ] = None,
    radius_mm: Annotated[float, typer.Option(help="With --camera: the fruits' radius.")] = 30.0,
    radius_sigma_mm: Annotated[
        float, typer.Option(help="Its standard deviation: the gap before the fruit grows with it.")
    ] = 0.0,
    seconds: Annotated[
        float | None, typer.Option(help="With --camera: how long; until Ctrl-C by default.")
    ] = None,
) -> None:
    """Drive the strawberry or the tomato rig from target to target, or to what a camera sees.

    A table shows where it is; with a camera, the numbers of the last picture. Ctrl-C stops the
    motors first. At the first target that cannot be driven to the motors stop, and the rest of the
    list is named. Needs the extra `drivers` (with a camera, `vision` too), and for the simulated
    rig a checkout with `make firmware`.
    """
    with exit_codes() as kept:
        from .._drive import DriveRequest, Row, count, drive_words, one_of

        one_of(targets, camera)
        if camera is not None:
            from .._point import PointRequest, Summary, point, said

            summary = Summary()
            kept.what = lambda: f"servos hold or are off; {said(summary)}"
            pointing = PointRequest(
                rig,
                port,
                camera,
                calibration,
                camera_calibration,
                camera_pose,
                radius_mm / 1000,
                radius_sigma_mm / 1000,
                seconds,
                log,
            )
            point(pointing, summary)
            with telling():
                typer.echo(said(summary))
            return
        assert targets is not None
        rows: list[Row] = []
        kept.what = lambda: f"motors are stopped; {count(rows)}" if rows else "nothing has moved"
        request = DriveRequest(
            rig=rig,
            port=port,
            targets=targets,
            calibration=calibration,
            method=method,
            psi_deg=psi,
            h_extra_mm=h_extra,
            near=near,
            log=log,
        )
        drive_words(request, rows)
        with telling():
            typer.echo(count(rows))
