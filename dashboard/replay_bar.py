"""The slider over a recording that is played in the place of a robot."""

from typing import Any

import viser

from bus import Node

from .errands import Errands, Outcome
from .rhythm import Rhythm

PLAYER = "/player/rpc:i"  # whoever plays answers here
RATE = 2.0  # [Hz] of looks at the position
ANSWER = 2.0  # [s]
STEP = 0.01  # [s] of the recording


class ReplayBar:
    """Shows the player's position, and moves it; hidden while nobody plays."""

    def __init__(self, gui: viser.GuiApi):
        self.present = False
        self._slider = gui.add_slider(
            "Log [s]", 0.0, 1.0, STEP, 0.0, hint="Position in the recording; move it to go there"
        )
        self._slider.visible = False
        self._slider.on_update(self._moved)
        self._wanted: float | None = None
        self._asked = 0  # requests that are under way
        self._rhythm = Rhythm(RATE)

    def update(self, node: Node, errands: Errands, now: float) -> None:
        """Look whether somebody plays, carry out what was moved, and renew the position."""
        present = node.directory.leader(PLAYER) is not None
        if present != self.present:
            self.present = self._slider.visible = present
        if not present:
            self._wanted = None
        elif (wanted := self._wanted) is not None:
            self._wanted = None
            self._ask(errands, "seek", {"time": wanted})
        elif self._rhythm.due(now) and not self._asked:
            self._ask(errands, "status", {})

    def _moved(self, event: viser.GuiEvent) -> None:
        """Called in viser's threads; what the page itself sets has no client."""
        if event.client is not None:
            self._wanted = event.target.value

    def _ask(self, errands: Errands, verb: str, arguments: dict[str, Any]) -> None:
        self._asked += 1
        errands.send(verb, PLAYER, verb, arguments, ANSWER, self._show)

    def _show(self, outcome: Outcome) -> None:
        self._asked -= 1
        if outcome.error is not None or self._wanted is not None or self._asked:
            return  # a newer answer is on the way
        told = outcome.value
        self._slider.max = max(told["duration"], STEP)
        self._slider.value = told["position"]
