"""The page: what is drawn when."""

import time
from typing import NamedTuple

from bus import Node
from robot_model import Robot
from robot_model.surface import Surface

from . import recording
from .actions import Actions
from .bars import torque_bars
from .config import DashboardConfig
from .errands import Errands
from .html import line, note
from .input_rows import input_table
from .inputs import Inputs
from .last_contact import LastContact
from .loading import Loading
from .offsets import offset_table
from .onset_strip import OnsetStrip
from .panel import Panel
from .port_rows import port_table
from .rhythm import Rhythm
from .server import PageServer
from .snapshot import Snapshot
from .status import status
from .touch_table import touch_table
from .touches import alarm
from .view import View
from .watch import Watch
from .wrench_table import wrench_table

ROOM = 0.5  # [s] between requests to go slower


class Browsers(NamedTuple):
    """What browsers do."""

    watch: bool  # at least one
    load: bool  # one that has not drawn the robot yet, and needs the processors


class Page:
    """All parts of the page and their rhythms."""

    def __init__(
        self,
        node: Node,
        robot: Robot,
        surface: Surface,
        server: PageServer,
        config: DashboardConfig,
    ):
        self._node, self._robot, self._server, self._config = node, robot, server, config
        self._inputs = Inputs(node, robot, config.inputs)
        self._view = View(server.scene, robot, surface, config)
        self._panel = Panel(server.gui, robot, tuple(b.name for b in surface.bodies), config)
        server.scene.on_click()(self._panel.poke)
        self._errands = Errands(node)
        self._actions = Actions(
            self._panel, self._errands, robot, surface, self._view.estimate, config
        )
        self._watch = Watch(node, config.watch_period, lambda: self.watched)
        self._loading = Loading(server) if config.makes_room else None
        self._requests = Rhythm(1.0 / ROOM)
        self._charts = Rhythm(config.chart_rate)
        self._lines = Rhythm(config.alarm_rate)
        self._texts = Rhythm(config.text_rate)
        self._default_links = {tree.name: tree.default_link for tree in robot.subtrees}
        self._last_contact = LastContact()
        self._strip = OnsetStrip(tuple(self._default_links))
        self._camera_set = False

    @property
    def watched(self) -> bool:
        """Whether a browser looks at the page."""
        return bool(self._server.get_clients())

    def update(self) -> None:
        """Draw one frame."""
        now = time.monotonic()
        self._inputs.want("contact_map", self._panel.show_places.value)
        known = self._inputs.read()
        self._actions.paused = self._node.clock.state == "paused"
        self._actions.holding = self._watch.holding
        self._actions.recording = bool(self._watch.recorder.get("recording"))
        self._panel.replay.update(self._node, self._errands, now)
        if self.watched:
            self._panel.tuning.update(self._node, self._errands, now)
        self._actions.replaying = self._panel.replay.present
        self._actions.run()
        with self._server.atomic():
            if not self._actions.frozen:
                self._draw(known, now)
            if self._lines.due(now):
                self._say(known, now)

    def look(self) -> Browsers:
        """Look for browsers; while one loads the page, let a simulation make room for it."""
        loads = self._loading is not None and self._loading.look()
        if loads and self._requests.due(time.monotonic()):
            self._actions.slow_down(2.0 * ROOM)
        return Browsers(self.watched, loads)

    def rest(self, resting: bool) -> None:
        """Read nothing while nobody looks, or go on."""
        self._inputs.rest(resting)
        self._panel.chart.clear()

    def close(self) -> None:
        """End the threads of the page."""
        if self._loading is not None:
            self._loading.close()
        self._watch.close()
        self._errands.close()

    def _draw(self, known: Snapshot, now: float) -> None:
        panel = self._panel
        self._strip.add(self._inputs.time("contacts"), known.contacts)
        self._view.update(known, panel.show_truth.value, panel.hide_below.value)
        self._set_camera()
        if self._node.clock.state != "paused":
            panel.chart.add(now, known.residuals)
            if self._charts.due(now):
                panel.chart.draw()
        if self._texts.due(now):
            self._draw_torques(known)
            panel.strip.content = self._strip.html(known.contacts)
            panel.ports.content = port_table(self._watch.outputs, self._inputs.ages())
            panel.inputs.content = input_table(self._watch.inputs)
            panel.wrenches.content = wrench_table(known.wrenches, tuple(self._default_links))
            panel.offsets.content = offset_table(self._watch.observer)

    def _draw_torques(self, known: Snapshot) -> None:
        if known.torques is None:
            self._panel.torques.content = note("torques", self._inputs.trouble("torques"))
            return
        truth = known.truth if self._panel.show_truth.value else None
        self._panel.torques.content = torque_bars(
            self._robot.joints,
            known.torques.torque,
            known.torques.valid,
            self._robot.torque_limit,
            None if truth is None else truth.link_torque,
        )

    def _say(self, known: Snapshot, now: float) -> None:
        """Renew status and alarm line, and the labels of the buttons that change their meaning."""
        actions, panel = self._actions, self._panel
        said = status(
            paused=actions.paused,
            frozen=actions.frozen,
            stale=self._inputs.trouble("sensors") or self._inputs.trouble("base"),
            replay=self._config.replay or actions.replaying,
            time=self._inputs.time("sensors"),
            holding=actions.holding,
            fallen=known.truth is not None and known.truth.fallen,
        )
        panel.status.content = line("status", said.text, said.colour)
        reason = self._inputs.trouble("contacts")
        alarmed = alarm(known.contacts, reason, self._default_links)
        panel.alarm.content = line("alarm", alarmed.text, alarmed.colour, "17px")
        panel.touches.content = touch_table(known.contacts)
        self._last_contact.note(alarmed, now)
        panel.last.content = note("last", self._last_contact.text(now))
        panel.pause.label = "Resume" if actions.paused or actions.frozen else "Pause"
        panel.record.label = recording.label(self._watch.recorder)
        panel.recording.content = recording.line(self._watch.recorder)
        panel.stop.label = "Release" if actions.holding else "Stop"

    def _set_camera(self) -> None:
        camera = None if self._camera_set else self._view.camera()
        if camera is not None:
            start = self._server.initial_camera
            start.position, start.look_at = camera
            self._camera_set = True
