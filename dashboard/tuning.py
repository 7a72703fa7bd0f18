"""Thresholds and gains of the contact detector, adjusted while it runs."""

from functools import partial
from typing import Any, NamedTuple

import viser

from bus import Node
from robot_model import ports

from .errands import Errands, Outcome
from .html import GREEN, GREY, RED, note
from .rhythm import Rhythm

DETECTOR = ports.rpc("contact_detector")
RATE = 1.0  # [Hz] of looks at the settings: others change them too
TITLE = "Contact detector. Changes are in force at once, and until it ends, unless saved."
ANSWER = 2.0  # [s]


Widget = viser.GuiSliderHandle[float] | viser.GuiDropdownHandle[str]


class Setting(NamedTuple):
    """A setting of the detector, and the range of its slider."""

    name: str
    label: str
    least: float
    most: float
    step: float


SETTINGS = (
    Setting("levels.contact", "Contact [std]", 1.0, 30.0, 0.1),
    Setting("levels.release", "Release, of that", 0.1, 0.95, 0.05),
    Setting("levels.collision", "Collision [N]", 5.0, 200.0, 1.0),
    Setting("residuals.internal_gain", "Gain joints [1/s]", 1.0, 200.0, 1.0),
    Setting("residuals.external_gain", "Gain base [1/s]", 1.0, 200.0, 1.0),
    Setting("residuals.sigmas", "Residuals [std]", 1.0, 20.0, 0.5),
    Setting("residuals.internal_floor", "Joint min [N m]", 0.05, 10.0, 0.05),
    Setting("residuals.force_floor", "Base min [N]", 0.1, 30.0, 0.1),
    Setting("residuals.moment_floor", "Base min [N m]", 0.05, 10.0, 0.05),
    Setting("model_error", "Model error", 0.0, 0.2, 0.005),
    Setting("gain_error", "Gain error", 0.0, 0.2, 0.005),
    Setting("drift_time", "Slow tare [s]", 1.0, 300.0, 1.0),
)
METHOD, METHODS = "method", ("surface", "line", "particle")  # of finding the place of a touch


class Tuning:
    """A widget per setting; callbacks only take note, the page's loop does the rest."""

    def __init__(self, gui: viser.GuiApi):
        self._state = gui.add_html(note("tuning-state", TITLE))
        self._widgets: dict[str, Widget] = {s.name: _add_slider(gui, s) for s in SETTINGS}
        self._widgets[METHOD] = gui.add_dropdown("Locate by", METHODS, visible=False, hint=METHOD)
        for name, widget in self._widgets.items():
            widget.on_update(partial(self._moved, name))
        reset = gui.add_button(
            "Reset settings", hint="To the detector's configuration", color="gray"
        )
        reset.on_click(lambda _: self._reset())
        save = gui.add_button("Save settings", hint="Into a file on its machine", color="gray")
        save.on_click(lambda _: self._requests.append({"action": "save"}))
        self._said = gui.add_html(note("tuning", ""))
        self._wanted: dict[str, float | str] = {}
        self._requests: list[dict[str, Any]] = []
        self._asked = 0  # requests that are under way
        self._rhythm = Rhythm(RATE)

    def update(self, node: Node, errands: Errands, now: float) -> None:
        """Carry out what was moved and pressed, and show what is in force."""
        if node.directory.leader(DETECTOR) is None:
            self._wanted.clear()
            self._requests.clear()
            self._state.content = note("tuning-state", "no contact detector on this bus")
            return
        requests = [self._requests.pop(0) for _ in range(len(self._requests))]
        while self._wanted:
            name, value = self._wanted.popitem()
            requests.append({"action": "set", "name": name, "value": value})
        if not requests and not self._asked and self._rhythm.due(now):
            requests = [{"action": "list"}]
        for request in requests:
            self._ask(errands, request)

    def _moved(self, name: str, event: viser.GuiEvent) -> None:
        """Called in viser's threads; what the page itself sets has no client."""
        if event.client is not None:
            self._wanted[name] = event.target.value

    def _reset(self) -> None:
        shown = (name for name, widget in self._widgets.items() if widget.visible)
        self._requests += [{"action": "reset", "name": name} for name in shown]

    def _ask(self, errands: Errands, request: dict[str, Any]) -> None:
        self._asked += 1
        then = partial(self._answered, request)
        errands.send("param", DETECTOR, "param", request, ANSWER, then)

    def _answered(self, request: dict[str, Any], outcome: Outcome) -> None:
        self._asked -= 1
        action, name = request["action"], request.get("name", "")
        if action == "list":
            said = (TITLE, GREY) if outcome.error is None else (str(outcome.error), RED)
            self._state.content = note("tuning-state", *said)
            if outcome.error is None:
                self._show(outcome.value)
        elif outcome.error is not None:
            self._say(f"{action} {name}: {outcome.error}", RED)
        elif action == "reset":
            self._say("reset to the detector's configuration", GREEN)
        elif action == "save":
            self._say(outcome.value["message"], GREEN)
        else:
            self._say(f"{name} = {outcome.value}", GREEN)

    def _show(self, values: dict[str, Any]) -> None:
        """Show what is in force, unless something newer is on its way."""
        if self._wanted or self._requests or self._asked:
            return
        for name, widget in self._widgets.items():
            widget.visible = name in values
            if name in values and widget.value != values[name]:
                _set(widget, values[name])

    def _say(self, text: str, colour: str) -> None:
        self._said.content = note("tuning", text, colour)


def _set(widget: Widget, value: Any) -> None:
    if isinstance(widget, viser.GuiSliderHandle):
        widget.min, widget.max = min(widget.min, value), max(widget.max, value)
    elif value not in widget.options:
        widget.options = (*widget.options, value)
    widget.value = value


def _add_slider(gui: viser.GuiApi, setting: Setting) -> viser.GuiSliderHandle[float]:
    return gui.add_slider(
        setting.label,
        setting.least,
        setting.most,
        setting.step,
        setting.least,
        visible=False,
        hint=setting.name,
    )
