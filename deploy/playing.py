"""A player's keys and its progress bar."""

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from deploy.progress import bar as filled
from deploy.terminal import Keyboard, draw

if TYPE_CHECKING:
    from bus.recording.player import Player

JUMP = 5.0  # s
FASTER = 2.0
REDRAW = 0.1  # s
HELP = "space pause  s step  left/right 5 s  up/down speed  q quit"


class Controls:
    """Looks at the keyboard and draws the bar; ``quit`` is set by the key q."""

    def __init__(self, player: "Player", keyboard: Keyboard):
        self.quit = False
        self._player, self._keyboard, self._drawn = player, keyboard, 0.0
        self._keys: dict[str, Callable[[], Any]] = {
            " ": lambda: player.resume() if player.paused else player.pause(),
            "s": player.step,
            "\x1b[C": lambda: player.seek(player.position + JUMP),
            "\x1b[D": lambda: player.seek(player.position - JUMP),
            "\x1b[A": lambda: self._speed(FASTER),
            "\x1b[B": lambda: self._speed(1.0 / FASTER),
            "q": self._quit,
        }

    def spin(self) -> None:
        """Obey the keys, and draw when it is time to."""
        while key := self._keyboard.read():
            self._keys.get(key, lambda: None)()
        if (now := time.monotonic()) - self._drawn > REDRAW:
            self._drawn = now
            draw(bar(self._player.status()))

    def _speed(self, factor: float) -> None:
        try:
            self._player.rate(self._player.status()["rate"] * factor)
        except ValueError:  # as fast or slow as it gets
            pass

    def _quit(self) -> None:
        self.quit = True


def bar(told: dict[str, Any]) -> str:
    """Return the progress of a player, given its status."""
    duration = max(told["duration"], 1e-9)
    state = "ended" if told["ended"] else "paused" if told["paused"] else f"x{told['rate']:g}"
    line = filled(told["position"] / duration)
    return f"{line} {told['position']:.1f} / {duration:.1f} s  {state}  {HELP}"
