"""The tabs beside target and joints, made in the order in which they are read."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .._checks import FloatArray
from ..errors import ArgumentError
from ._export_tab import ExportTab
from ._panel import Panel
from ._path_tab import PathTab
from ._reach_tab import ReachTab
from ._rig_tab import RigTab
from ._scene_tab import SceneTab


class Tabs:
    """All tabs of a panel but those of target and joints."""

    def __init__(self, panel: Panel) -> None:
        tabs = panel.tabs
        self.scene = SceneTab(panel, tabs.add_tab("Scene"))
        self.reach = ReachTab(panel, tabs.add_tab("Reach"))
        self.path = PathTab(panel, tabs.add_tab("Path"))
        self.rig = RigTab(panel, tabs.add_tab("Rig"))
        self.export = ExportTab(panel, self.path, tabs.add_tab("Export"))

    def take_targets(self, targets: FloatArray) -> None:
        """Take targets to step through, and aim at the first."""
        right = targets.ndim in (2, 3) and targets.shape[1:] in ((3,), (4, 4)) and len(targets)
        if not right or not np.isfinite(targets).all():
            expected = "shape (n, 3) or (n, 4, 4), finite"
            raise ArgumentError("targets", f"shape {targets.shape}", expected)
        self.path.targets(targets)
        self.path.aim_at(0)

    def take_path(self, file: Path) -> None:
        """Take the way of a file."""
        self.path.read(file)

    def stop(self) -> None:
        """End what runs beside the panel."""
        self.path.stop()
        self.rig.close()
