"""The tab of the simulated rigs: the boards' own programs move the arm that is shown."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from typing import Any

import numpy as np

from ..drivers import RigError, RigStatus, StrawberryRig, TomatoRig
from ..errors import AgrikError
from ._panel import Panel

RIGS: dict[str, Callable[..., StrawberryRig | TomatoRig]] = {
    "strawberry": StrawberryRig,
    "strawberry6": StrawberryRig,
    "tomato": TomatoRig,
}
"""Rigs by the arms that show them."""
# A picture is worth drawing so often, s of the rig's own time.
_EVERY = 0.05


class RigTab:
    """A simulated rig: homed, driven to the target, stopped. Its encoders are what is drawn."""

    def __init__(self, panel: Panel, tab: Any) -> None:
        self._panel = panel
        self._rig: StrawberryRig | TomatoRig | None = None
        self._thread: threading.Thread | None = None
        self._clock = -np.inf
        gui = panel.server.gui
        with tab:
            self._words = gui.add_markdown("")
            self._start = gui.add_button("start the simulated rig")
            self._drive = gui.add_button("drive to the target", disabled=True)
            self._reset = gui.add_button("bring it home", disabled=True)
            self._halt = gui.add_button("stop its motors", disabled=True)
            self._psi = gui.add_number("psi of the rig [deg]", 0.0, min=-90.0, max=90.0)
        self._start.on_click(lambda _: self._do("starting and homing", self.start))
        self._drive.on_click(lambda _: self._do("driving to the target", self.drive))
        self._reset.on_click(lambda _: self._do("coming home", self.bring_home))
        self._halt.on_click(lambda _: self._stop_motors())
        panel.loaded.append(self._loaded)
        self._loaded()

    def _loaded(self) -> None:
        self.close()
        name = self._panel.session.robot.name
        known = name in RIGS
        self._start.disabled = not known
        self._psi.visible = name == "strawberry6"
        self._words.content = (
            "A simulator runs the board's own program, wired to a simulated plant."
            if known
            else f"{name} has no rig; {', '.join(RIGS)} have one."
        )

    def close(self) -> None:
        """End the simulated rig."""
        if self._rig is not None:
            with contextlib.suppress(AgrikError):
                self._rig.stop()
            if self._thread is not None and self._thread is not threading.current_thread():
                self._thread.join(timeout=5.0)
            with contextlib.suppress(AgrikError):
                self._rig.close()
            self._rig = None
        for button in (self._drive, self._reset, self._halt):
            button.disabled = True

    def _do(self, what: str, job: Callable[[], str]) -> None:
        if self._thread is not None and self._thread.is_alive():
            return

        def run() -> None:
            self._words.content = f"{what} ..."
            try:
                self._words.content = job()
            except AgrikError as error:
                self._words.content = f"**{type(error).__name__}**: {error}"

        self._thread = threading.Thread(target=run, name="agrik-rig", daemon=True)
        self._thread.start()

    def start(self) -> str:
        """Start and home the rig; returns what to say."""
        make = RIGS[self._panel.session.robot.name]
        self.close()
        self._clock = -np.inf
        rig = make("simulated", progress=self._moved)
        rig.connect()
        self._rig = rig
        self._halt.disabled = False
        rig.home()
        self._drive.disabled = False
        self._reset.disabled = False
        return f"{rig.name} rig: homed"

    def drive(self) -> str:
        """Drive the rig to the session's target; returns what to say."""
        rig, session = self._homed(), self._panel.session
        point = session.target[:3, 3]
        if isinstance(rig, StrawberryRig):
            psi = float(np.radians(self._psi.value)) if session.robot.dof == 6 else 0.0
            run = rig.pick(target=point, psi=psi)
            off = 1000 * max(abs(step.encoder_error) for step in run.steps)
            return f"picked in {run.seconds:.1f} s, encoders within {off:.2f} mm"
        status = rig.move(target=point)
        return "pointing, servos at " + ", ".join(f"{x:.1f}°" for x in np.degrees(status.q))

    def bring_home(self) -> str:
        """Bring the rig home; returns what to say."""
        rig = self._homed()
        if isinstance(rig, StrawberryRig):
            return f"home in {rig.reset().seconds:.1f} s"
        rig.home()
        return "home"

    def _homed(self) -> StrawberryRig | TomatoRig:
        if self._rig is None:
            raise RigError("the simulated rig is not started")
        return self._rig

    def _stop_motors(self) -> None:
        if self._rig is not None:
            with contextlib.suppress(AgrikError):
                self._rig.stop()
            self._words.content = "motors are stopped"

    def _moved(self, status: RigStatus) -> None:
        """Draw the rig where its encoders say it is."""
        if status.clock - self._clock < _EVERY:
            return
        self._clock = status.clock
        self._panel.worker.submit("rig", lambda: self._draw(status))

    def _draw(self, status: RigStatus) -> None:
        session = self._panel.session
        known = status.q[: session.robot.dof]
        session.q = np.where(np.isfinite(known), known, session.robot.home)
        self._panel.stage.pose(session.q, session.opening)
