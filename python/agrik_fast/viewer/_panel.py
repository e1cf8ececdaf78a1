"""The panel beside the picture: status, robot, solver, target, joints."""

from __future__ import annotations

import html
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from ..errors import AgrikError
from ..robot import LOOKS, Look, Robot
from ._camera import viewpoint
from ._session import TASKS, Branch, Session
from ._stage import Stage
from ._worker import Worker

# Text for eyes: at most so often, s; fields beside a hand that drags: a browser takes longer for
# them than for all the rest.
_TEXT_EVERY = 0.05
_FIELDS_EVERY = 0.3
_PHONE = 600
"""Pictures narrower than this are those of telephones, px."""
_WIDE = 1.5
_FIELDS = ("x [m]", "y [m]", "z [m]", "roll [deg]", "pitch [deg]", "yaw [deg]")
# Dark enough to be read on white: contrast 7.2 and 5.9.
_WORD_COLOURS = {True: "#00507d", False: "#a84300"}
_BRANCHES = "all branches"
# Below the window with the status, px.
_TABS_AT, _TABS_WIDE = 175, 320


class Panel:
    """Widgets of the arm and its target; call-backs change the session on the worker alone.

    Parameters
    ----------
    server : viser.ViserServer
    session : Session
    show : {"auto", "chain", "bodies", "visuals"}
    """

    def __init__(self, server: Any, session: Session, show: Look = "auto") -> None:
        self.server = server
        self.session = session
        self.stage = Stage(server)
        self.worker = Worker(self._failed)
        self.show: Look = show
        self.scale = 1.0
        self.loaded: list[Callable[[], None]] = []
        """Told after another arm was taken."""
        self.note = ""
        self._said = 0.0
        self._filled = 0.0
        self._found: list[Branch] = []
        self._joints: list[Any] = []
        gui = server.gui
        gui.configure_theme(show_logo=False, show_share_button=False, brand_color=(0, 80, 125))
        self._status = gui.add_html("")
        # A window of its own: on a phone it is folded away, and the status stays.
        self.tabs = gui.add_panel()
        self.tabs.float(x=-15, y=_TABS_AT, width=_TABS_WIDE)
        with self.tabs.add_tab("Target"):
            self._target_tab()
        self._joints_tab = self.tabs.add_tab("Joints")
        self._commands()
        self._robot.on_update(self._when("robot", lambda: self._choose_robot(self._robot.value)))
        self._solver.on_update(self._when("solver", self._choose_solver))
        self._task.on_update(self._when("task", self._choose_task))
        server.on_client_connect(self._connected)
        self.reload()

    # -- widgets -----------------------------------------------------------------------------

    def _target_tab(self) -> None:
        gui, session = self.server.gui, self.session
        names = Robot.names()
        source = session.source
        self._robot = gui.add_dropdown(
            "robot", names if source in names else (source, *names), initial_value=source
        )
        self._solver = gui.add_dropdown("solver", session.solvers(), initial_value=session.solver)
        self._task = gui.add_dropdown("task", TASKS, initial_value=session.task)
        self._numbers = [
            gui.add_number(label, 0.0, step=0.001 if "[m]" in label else 0.1) for label in _FIELDS
        ]
        for field in self._numbers:
            field.on_update(self._when("numbers", self._aim_numbers))
        buttons = gui.add_button_group("target", ("home", "undo", "redo"))
        actions = {"home": self._home, "undo": self._undo, "redo": self._redo}
        buttons.on_click(lambda event: self.worker.submit("button", actions[event.target.value]))
        self._all = gui.add_checkbox(_BRANCHES, False, hint="every posture that reaches the target")
        self._branch = gui.add_slider("branch", 1, 2, 1, 1, disabled=True)
        self._branch_words = gui.add_markdown("")
        self._elbow = gui.add_slider("elbow [deg]", -180.0, 180.0, 1.0, 0.0, visible=False)
        self._elbow_words = gui.add_markdown("", visible=False)
        self._all.on_update(self._when("branches", self._show_branches))
        self._branch.on_update(self._when("branch", self._choose_branch))
        self._elbow.on_update(self._when("elbow", self._turn_elbow))

    def _commands(self) -> None:
        gui = self.server.gui
        for label, key, action in (
            ("Undo the target", "Z", self._undo),
            ("Redo the target", "Y", self._redo),
        ):
            command = gui.add_command(label, hotkey=key, modifier="cmd/ctrl")
            command.on_trigger(lambda _event, action=action: self.worker.submit("button", action))

    def _when(self, kind: str, job: Callable[[], None]) -> Callable[[Any], None]:
        """Return a call-back for what a person did; what the program set itself is no news."""

        def happened(event: Any) -> None:
            if event.client is not None:
                self.worker.submit(kind, job)

        return happened

    def _failed(self, error: Exception) -> None:
        words = str(error) if isinstance(error, AgrikError) else f"{type(error).__name__}: {error}"
        self.say(words, good=False)

    # -- another arm -------------------------------------------------------------------------

    def _choose_robot(self, name: str) -> None:
        self.session.load(Robot.load(name), name)
        self.reload()

    def reload(self) -> None:
        """Draw the session's arm anew."""
        session, stage = self.session, self.stage
        self._all.value = False
        stage.load(session.robot, self.show, self.scale)
        stage.handle.on_update(self._dragged)
        stage.rotations(session.task != "position")
        self._look_at_arm()
        self._solver.value, self._task.value = session.solver, session.task
        self._elbow.visible = self._elbow_words.visible = session.has_arm_angle
        self._joint_sliders()
        for told in self.loaded:
            told()
        self.refresh()

    def show_as(self, look: str) -> None:
        """Show the arm as something else: chain, bodies, visuals."""
        before = self.show
        self.show = next(each for each in LOOKS if each == look)
        try:
            self.reload()
        except AgrikError:
            self.show = before
            self.reload()
            raise

    def _look_at_arm(self) -> None:
        clients = [client.camera for client in self.server.get_clients().values()]
        for camera in (self.server.initial_camera, *clients):
            self._aim_camera(camera)

    def _aim_camera(self, camera: Any) -> None:
        """Have a camera look at arm and handle; of a picture not yet known: a wide one."""
        robot = self.session.robot
        arm = robot.frames_of(self.session.q)[:, :3, 3]
        width = getattr(camera, "image_width", 0)
        aspect = width / camera.image_height if width else _WIDE
        tips = self.stage.handle_tips(self.session.target)
        place, middle = viewpoint(arm, tips, 0.5 * robot.reach_radius, aspect)
        camera.position = tuple(place.tolist())
        camera.look_at = tuple(middle.tolist())

    def _connected(self, client: Any) -> None:
        if client.camera.image_width < _PHONE:
            number = client.client_id
            self.worker.submit(f"phone {number}", lambda: self._suit_phone(client.camera))

    def _suit_phone(self, camera: Any) -> None:
        # A finger is wider than the tip of a mouse's arrow.
        self.scale = 1.5
        self.stage.handle.scale = self.scale * self.stage.handle_size()
        self._aim_camera(camera)

    def _joint_sliders(self) -> None:
        for slider in self._joints:
            slider.remove()
        robot = self.session.robot
        self._joints = []
        with self._joints_tab:
            for name, kind, low, high in zip(
                robot.joint_names, robot.joint_types, robot.lower, robot.upper, strict=True
            ):
                unit, factor = ("mm", 1000.0) if kind == "prismatic" else ("deg", 180 / np.pi)
                free = 1000.0 if kind == "prismatic" else 180.0
                ends = [
                    float(factor * value) if np.isfinite(value) else bound
                    for value, bound in ((low, -free), (high, free))
                ]
                slider = self.server.gui.add_slider(f"{name} [{unit}]", *ends, 0.1, ends[0])
                slider.on_update(self._when("joints", self._move_joints))
                self._joints.append(slider)

    # -- what a person does --------------------------------------------------------------------

    def _dragged(self, event: Any) -> None:
        if event.client is None:
            return
        if event.phase == "start":
            self.worker.submit("remember", self.session.remember)
        self.worker.submit("drag", self._aim_handle)

    def _aim_handle(self) -> None:
        handle = self.stage.handle
        from ..rotations import pose

        target = pose(handle.position, quat=np.roll(handle.wxyz, -1))
        self.session.aim(target, remember=False)
        self.refresh(handle=False, fields=False)
        wait = self._filled + _FIELDS_EVERY - time.monotonic()
        self.worker.submit("fields", self._fill, after=max(wait, 0.0))

    def _aim_numbers(self) -> None:
        self.session.aim_numbers([field.value for field in self._numbers])
        # A number that is being typed is not written over.
        self.refresh(numbers=False)

    def _move_joints(self) -> None:
        kinds = self.session.robot.joint_types
        factor = [0.001 if kind == "prismatic" else np.pi / 180 for kind in kinds]
        self.session.move_joints(np.array([s.value for s in self._joints]) * factor)
        self.refresh(joints=False)

    def _choose_solver(self) -> None:
        self.session.solver = self._solver.value
        self._again()

    def _choose_task(self) -> None:
        self.session.task = self._task.value
        self.stage.rotations(self.session.task != "position")
        self._again()

    def _again(self) -> None:
        self.session.outcome = self.session.solve()
        self.refresh()

    def _home(self) -> None:
        self.session.move_joints(self.session.robot.home)
        self.refresh()

    def _undo(self) -> None:
        if self.session.undo():
            self.refresh()

    def _redo(self) -> None:
        if self.session.redo():
            self.refresh()

    # -- branches ----------------------------------------------------------------------------

    def _show_branches(self) -> None:
        self._found = self.session.branches() if self._all.value else []
        count = len(self._found)
        self._branch.disabled = count < 2
        self._branch.max = max(count, 2)
        self._branch.value = 1
        self.stage.branches([branch.q for branch in self._found])
        if not self._all.value:
            self._branch_words.content = ""
        elif not count:
            reason = self.session.robot.family.reason or "none is in the limits"
            self._branch_words.content = f"no branches: {reason}"
        else:
            self._branch_words.content = self._branch_line(0)

    def _branch_line(self, row: int) -> str:
        far = self._found[row].distance
        return f"branch {row + 1} of {len(self._found)}, {far:.2f} rad from where the arm was"

    def _choose_branch(self) -> None:
        row = int(self._branch.value) - 1
        if 0 <= row < len(self._found):
            self.session.choose(self._found[row].q)
            self._branch_words.content = self._branch_line(row)
            self.refresh(branches=False)

    def _turn_elbow(self) -> None:
        self.session.outcome = self.session.turn_elbow(self._elbow.value)
        self.refresh(elbow=False)

    # -- what is shown ---------------------------------------------------------------------------

    def refresh(
        self,
        *,
        handle: bool = True,
        numbers: bool = True,
        joints: bool = True,
        elbow: bool = True,
        branches: bool = True,
        fields: bool = True,
    ) -> None:
        """Show the session as it is; the arguments say what a person holds just now."""
        session, stage, outcome = self.session, self.stage, self.session.outcome
        with self.server.atomic():
            stage.pose(session.q, session.opening)
            stage.nearest(None if outcome.reached else outcome.q)
            stage.verdict(outcome.good, _why(session))
            if handle:
                stage.target(session.target)
        # Of many drags in a row only the last has to be read.
        if self.worker.waiting() and time.monotonic() - self._said < _TEXT_EVERY:
            return
        place = "target " + ", ".join(f"{value:.3f}" for value in session.target[:3, 3]) + " m"
        lines = [outcome.nearness, place, self.note]
        # What a person waits for goes before the fields.
        self.say(outcome.headline, *filter(None, lines), good=outcome.good)
        if fields:
            self._fill(numbers=numbers, joints=joints, elbow=elbow, branches=branches)

    def _fill(
        self,
        *,
        numbers: bool = True,
        joints: bool = True,
        elbow: bool = True,
        branches: bool = True,
    ) -> None:
        """Write target, joints, elbow and branches into their fields."""
        session = self.session
        self._filled = time.monotonic()
        if numbers:
            for field, value in zip(self._numbers, session.numbers(), strict=True):
                field.value = round(value, 5 if "[m]" in field.label else 3)
        if joints:
            kinds = session.robot.joint_types
            for slider, kind, value in zip(self._joints, kinds, session.q, strict=True):
                shown = 1000 * value if kind == "prismatic" else np.degrees(value)
                slider.value = float(np.clip(round(shown, 2), slider.min, slider.max))
        if session.has_arm_angle:
            if elbow:
                angle = float(np.degrees(session.robot.arm_angle(session.q)))
                self._elbow.value = round(angle)
            self._elbow_words.content = session.elbow_intervals()
        if branches and self._all.value and not self.worker.waiting():
            self._show_branches()

    def say(self, first: str, *more: str, good: bool) -> None:
        """Show lines in the status, and the first in the panel's head, which a phone shows."""
        self._said = time.monotonic()
        colour = _WORD_COLOURS[good]
        # Not by colour alone: a bar that is broken where something is wrong.
        style = (
            f"margin:0.4em 0.8em;padding:0 1em 0 0.6em;color:{colour};"
            f"border-left:4px {'solid' if good else 'dashed'} {colour};font-size:0.9em;"
            "height:6em;overflow:auto"
        )
        rest = "".join(f"<div>{html.escape(line)}</div>" for line in more)
        self._status.content = (
            f'<div id="agrik-status" role="status" aria-live="polite" style="{style}">'
            f"<strong>{html.escape(first)}</strong>{rest}</div>"
        )
        self.server.gui.set_panel_label(first.partition("  ")[0])


def _why(session: Session) -> str:
    outcome = session.outcome
    return outcome.nearness if outcome.reached and outcome.hits else outcome.headline


def send_file(event: Any, name: str, content: bytes) -> None:
    """Have the browser that asked save a file."""
    if event.client is not None:
        event.client.send_file_download(name, content, save_immediately=True)
