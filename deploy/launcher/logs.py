"""What the services print, each line under its service's name."""

import sys
import threading
from typing import IO, TextIO

COLOURS = (36, 33, 32, 35, 34, 96, 93, 92, 95, 94)  # ANSI foreground


class Log:
    """Writes whole lines to one stream; remembers when nobody reads them any more."""

    def __init__(self, names: list[str], stream: TextIO | None = None):
        self.closed = False
        self._stream = stream or sys.stderr
        self._lock = threading.Lock()
        width = max(map(len, names))
        coloured = self._stream.isatty()
        self._prefixes = {
            name: _prefix(name.rjust(width), COLOURS[i % len(COLOURS)] if coloured else None)
            for i, name in enumerate(names)
        }

    def say(self, name: str, text: str) -> None:
        """Write one line."""
        with self._lock:
            try:
                self._stream.write(f"{self._prefixes[name]}{text}\n")
                self._stream.flush()
            except (BrokenPipeError, ValueError):
                self.closed = True

    def follow(self, name: str, lines: IO[bytes] | None) -> None:
        """Copy a child's output until it ends; the child never waits for us."""
        threading.Thread(target=self._copy, args=(name, lines), daemon=True).start()

    def _copy(self, name: str, lines: IO[bytes]) -> None:
        with lines:
            for line in lines:
                self.say(name, line.decode(errors="replace").rstrip())


def _prefix(name: str, colour: int | None) -> str:
    return f"{name} | " if colour is None else f"\033[{colour}m{name} |\033[0m "
