"""Options of harvest evaluations, of one scene and of many crops."""

from __future__ import annotations

from typing import Annotated

import typer

DistanceOption = Annotated[
    str, typer.Option("--distance", help="exact, or tree: boxes as spheres, as in the paper.")
]
Refine = Annotated[bool, typer.Option(help="Improve postures by a pattern search.")]
Recovery = Annotated[bool, typer.Option(help="Go on after the best approach angle has failed.")]
BlockersOption = Annotated[
    bool, typer.Option("--blockers/--no-blockers", help="Name the leaves in the way.")
]
Tilt = Annotated[float, typer.Option(help="Tilt that the gripper tolerates, deg.")]
Shift = Annotated[float, typer.Option(help="Shift along the fruit that it tolerates, m.")]
MinDistance = Annotated[float, typer.Option(help="Distance that postures keep from the crop, m.")]
