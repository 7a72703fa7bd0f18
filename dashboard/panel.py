"""The page's panel: lines, tabs, buttons."""

from collections import deque
from pathlib import Path
from typing import NamedTuple

import numpy as np
import viser

from bus.session import insecure_notice
from robot_model import Robot

from . import recording
from .chart import ResidualChart
from .config import DashboardConfig
from .html import AMBER, GREY, line, note
from .picking import Ray
from .push import DIRECTIONS
from .replay_bar import ReplayBar
from .tuning import Tuning

LEGEND = (
    "<style>#legend span {{white-space:nowrap;margin-right:10px}}</style>"
    '<div id="legend" style="font:11.5px/1.5 system-ui,sans-serif;padding:2px 12px">'
    '<span><b style="color:#ff7a2e">&#10142; estimated touch</b> 1 cm = {touch:g} N</span>'
    '<span><b style="color:#ffbe00">&#10142; estimated support</b> 1 cm = {support:g} N</span>'
    '<span><b style="color:#4aa3ff">&#9679;&#9472; true force</b> same scales</span>'
    '<span><b style="color:#ff46c8">&#9679; place of a touch</b> brighter: likelier</span>'
    '<span><b style="color:#ff46c8">&#9472;</b> its line of action</span></div>'
)
TORQUES = "Link torques [N m], limits at the bars' ends"


class Click(NamedTuple):
    """A button was pressed by a browser, or the scene clicked (``poke``, along ``ray``)."""

    button: str
    client: viser.ClientHandle | None
    ray: Ray | None = None


class Panel:
    """All widgets. Callbacks run in viser's threads, so they only append to ``clicks``."""

    def __init__(
        self, gui: viser.GuiApi, robot: Robot, links: tuple[str, ...], config: DashboardConfig
    ):
        self.clicks: deque[Click] = deque()
        self.status = gui.add_html(line("status", "stale: starting", GREY))
        if notice := insecure_notice():
            gui.add_html(note("insecure", notice, AMBER))
        self.alarm = gui.add_html(line("alarm", "contact unknown: starting", GREY, "17px"))
        self.last = gui.add_html("")
        self.replay = ReplayBar(gui)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Live"):
            self.chart = ResidualChart(gui, robot, config.chart_points, config.chart_seconds)
            self.strip = gui.add_html("")
            self._add_push(gui, robot, links, config)
            self._add_buttons(gui)
            self.result = gui.add_html(note("result", ""))
            self.recording = gui.add_html(note("recording", ""))
            self.touches = gui.add_html("")  # comes and goes: the buttons above it must not move
            self._add_legend(gui, config)
            self.wrenches = gui.add_html("")
            self.offsets = gui.add_html("")
            gui.add_html(note("torques-title", TORQUES))
            self.torques = gui.add_html("")
            self._add_view(gui, config)
        with tabs.add_tab("Tune"):
            self.tuning = Tuning(gui)
        with tabs.add_tab("Ports"):
            self.ports = gui.add_html(note("ports", "looking for ports"))
            self.inputs = gui.add_html("")
        with tabs.add_tab("Help"):
            gui.add_markdown((Path(__file__).parent / "help.md").read_text())

    def poke(self, event: viser.SceneClickEvent) -> None:
        """Take note of a click into the scene."""
        ray = Ray(np.array(event.ray_origin), np.array(event.ray_direction))
        self.clicks.append(Click("poke", event.client, ray))

    def _add_push(
        self, gui: viser.GuiApi, robot: Robot, links: tuple[str, ...], config: DashboardConfig
    ) -> None:
        usual = next((s.default_link for s in robot.subtrees[1:] if s.default_link in links), None)
        self.link = gui.add_dropdown("Link", links, initial_value=usual or links[0])
        self.direction = gui.add_dropdown(
            "Direction", tuple(DIRECTIONS), hint="of the force, along an axis of the world"
        )
        self.force = gui.add_slider("Force [N]", 1.0, config.push_limit, 1.0, config.push_force)
        self._add_button(gui, "Push", "push", "Push the simulated robot", "orange")

    def _add_buttons(self, gui: viser.GuiApi) -> None:
        self._add_button(gui, "Tare", "tare", "Take sensor offsets; nothing may touch", "gray")
        self.pause = self._add_button(gui, "Pause", "pause", "Pause the simulation", "gray")
        self.stop = self._add_button(gui, "Stop", "stop", "Hold posture, refuse commands", "red")
        hint = "Record everything on the bus into a file"
        self.record = self._add_button(gui, recording.BEGIN, "record", hint, "gray")

    def _add_button(
        self, gui: viser.GuiApi, label: str, name: str, hint: str, colour: str | None
    ) -> viser.GuiButtonHandle:
        button = gui.add_button(label, hint=hint, color=colour)  # type: ignore[arg-type]
        button.on_click(lambda event: self.clicks.append(Click(name, event.client)))
        return button

    def _add_legend(self, gui: viser.GuiApi, config: DashboardConfig) -> None:
        scales = {"touch": 0.01 / config.touch_scale, "support": 0.01 / config.support_scale}
        gui.add_html(LEGEND.format(**scales))

    def _add_view(self, gui: viser.GuiApi, config: DashboardConfig) -> None:
        self.show_truth = gui.add_checkbox(
            "True forces", True, hint="What the simulator knows, in blue; no estimate uses it"
        )
        self.show_places = gui.add_checkbox(
            "Places of a touch", True, hint="The map over the surface, and the line of action"
        )
        self.hide_below = gui.add_slider("Hide below [N]", 0.0, 20.0, 0.5, config.hide_below)
        self._add_button(gui, "Reset", "reset", "Stand the simulated robot up again", "gray")
