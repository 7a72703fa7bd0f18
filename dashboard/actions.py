"""What the buttons do."""

from typing import Any

import numpy as np

from robot_model import Robot, ports
from robot_model.surface import Surface

from . import recording
from .config import DashboardConfig
from .errands import Errands, Outcome
from .html import GREEN, RED, note
from .panel import Click, Panel
from .picking import pick
from .placement import Placement
from .push import DIRECTIONS, push_point, push_request
from .replay_bar import PLAYER

ANSWER = 2.0  # [s] within which a service that only switches something has answered
FINISHING = 10.0  # [s] for the recorder to finish its file
MEASURING = 3.0  # [s] more than a tare's own time
SLOWEST = 0.05  # of real time: a simulation in slow motion


class Actions:
    """Turns clicks into calls and shows how they ended, on the page and to who clicked.

    ``frozen`` is the pause of a page that has no simulator to pause.
    """

    def __init__(
        self,
        panel: Panel,
        errands: Errands,
        robot: Robot,
        surface: Surface,
        placement: Placement,
        config: DashboardConfig,
    ):
        self._panel, self._errands, self._config = panel, errands, config
        self._surface, self._placement = surface, placement
        self._sim = ports.sim_rpc(robot)
        self._verbs = {
            "push": self._push,
            "poke": self._poke,
            "tare": self._tare,
            "pause": self._pause,
            "stop": self._stop,
            "reset": self._reset,
            "record": self._record,
        }
        self.frozen = False
        self.paused = False  # the plant's clock stands still, or the recording's
        self.replaying = False  # somebody plays a recording
        self.holding = False  # the sensor server holds the posture
        self.recording = False  # the recorder records

    def run(self) -> None:
        """Carry out what was clicked, and show what has ended."""
        while self._panel.clicks:
            click = self._panel.clicks.popleft()
            self._verbs[click.button](click)
        self._errands.collect()

    def slow_down(self, seconds: float) -> None:
        """Let a simulation go slower for a while; nobody need know where there is none."""
        self._errands.send(
            "", self._sim, "slow_down", {"seconds": seconds}, ANSWER, lambda outcome: None
        )

    def _push(self, click: Click) -> None:
        link = self._panel.link.value
        direction = np.array(DIRECTIONS[self._panel.direction.value])
        force = self._panel.force.value * direction
        body = [body.name for body in self._surface.bodies].index(link)
        try:
            inward = self._placement.inverse_vector(link, direction)
            point = push_point(self._surface, body, inward)
        except ValueError as error:
            self._show(click, f"push: {error}", RED)
            return
        said = f"push {self._panel.force.value:g} N {self._panel.direction.value} on {link}"
        self._send_push(click, said, push_request(link, point, force, "world"))

    def _poke(self, click: Click) -> None:
        """Push where the robot was clicked, straight into its surface."""
        assert click.ray is not None
        try:
            spot = pick(click.ray, self._surface, self._placement)
        except ValueError as error:
            self._panel.result.content = note("result", f"click: {error}")
            return
        force = self._panel.force.value * spot.inward
        said = f"push {self._panel.force.value:g} N on {spot.link} where it was clicked"
        self._send_push(click, said, push_request(spot.link, spot.point, force, "link"))

    def _send_push(self, click: Click, said: str, push: dict[str, Any]) -> None:
        def then(outcome: Outcome) -> None:
            if outcome.absent:
                said = f"{outcome.label}: no simulator to push: {outcome.error}"
                self._show(click, said, RED)
            else:
                self._report(click, outcome)

        push["duration"] = self._config.push_duration
        self._errands.send(said, self._sim, "push", push, ANSWER, then)

    def _tare(self, click: Click) -> None:
        seconds, outcomes = self._config.tare_seconds, list[Outcome]()

        def then(outcome: Outcome) -> None:
            outcomes.append(outcome)
            self._report(click, *outcomes)

        self._show(click, f"tare: measuring for {seconds:g} s", GREEN)
        for service in ("torque_observer", "contact_detector"):
            port, limit = ports.rpc(service), seconds / SLOWEST + MEASURING
            self._errands.send(f"tare {service}", port, "tare", {"seconds": seconds}, limit, then)

    def _pause(self, click: Click) -> None:
        if self.frozen:
            self.frozen = False
            return
        verb = "resume" if self.paused else "pause"

        def then(outcome: Outcome) -> None:
            self.frozen = outcome.absent
            if outcome.absent:
                self._show(click, "pause: no simulator, so only this page stands still", GREEN)
            elif self.replaying and outcome.error is None:
                at = outcome.value["position"]
                self._show(click, f"{verb}: the recording is at {at:.1f} s", GREEN)
            else:
                self._report(click, outcome)

        port = PLAYER if self.replaying else self._sim
        self._errands.send(verb, port, verb, {}, ANSWER, then)

    def _stop(self, click: Click) -> None:
        verb = "release" if self.holding else "stop"
        self._send(click, verb, ports.rpc("sensor_server"), verb, {}, ANSWER)

    def _reset(self, click: Click) -> None:
        self._send(click, "reset", self._sim, "reset", {}, ANSWER)

    def _record(self, click: Click) -> None:
        def then(outcome: Outcome) -> None:
            if outcome.error is None and "error" in outcome.value:
                said = recording.text(outcome.value)
                self._show(click, said, RED if outcome.value["error"] else GREEN)
            else:
                self._report(click, outcome)

        verb = "stop" if self.recording else "start"
        self._errands.send("record", ports.rpc("recorder"), verb, {}, FINISHING, then)

    def _send(
        self,
        click: Click,
        label: str,
        port: str,
        verb: str,
        arguments: dict[str, Any],
        timeout: float,
    ) -> None:
        def then(outcome: Outcome) -> None:
            self._report(click, outcome)

        self._errands.send(label, port, verb, arguments, timeout, then)

    def _report(self, click: Click, *outcomes: Outcome) -> None:
        """Show how the calls of a click ended, those that failed first."""
        ordered = sorted(outcomes, key=lambda outcome: outcome.error is None)
        failed = ordered[0].error is not None
        self._show(click, "; ".join(map(_told, ordered)), RED if failed else GREEN)

    def _show(self, click: Click, text: str, colour: str) -> None:
        self._panel.result.content = note("result", text, colour)
        if click.client is not None:
            title = "failed" if colour == RED else "done"
            click.client.add_notification(
                title, text, color="red" if colour == RED else "green", auto_close_seconds=6.0
            )


def _told(outcome: Outcome) -> str:
    said = _summary(outcome.value) if outcome.error is None else outcome.error
    return f"{outcome.label}: {said}"


def _summary(value: Any) -> str:
    """Return a reply in words: its message if it has one, else its entries."""
    if not isinstance(value, dict):
        return "done" if value is None else str(value)
    if value.get("message"):
        return str(value["message"])
    return ", ".join(f"{key} {entry}" for key, entry in value.items()) or "done"
