"""Single keys from a terminal, and a line on it that is drawn again and again."""

import os
import select
import shutil
import sys
from typing import Any

LINE = "\r\x1b[K"  # to the first column, and clear


class Keyboard:
    """Keys as they are pressed; none where standard input is no terminal."""

    def __init__(self) -> None:
        self._file = sys.stdin.fileno() if sys.stdin and sys.stdin.isatty() else -1
        self._before: Any = None

    def __enter__(self) -> "Keyboard":
        if self._file >= 0:
            import termios
            import tty

            self._before = termios.tcgetattr(self._file)
            tty.setcbreak(self._file)
        return self

    def __exit__(self, *_: object) -> None:
        if self._before is not None:
            import termios

            termios.tcsetattr(self._file, termios.TCSADRAIN, self._before)

    def read(self) -> str:
        """Return the next key, or what the terminal sends for it; empty when none was pressed."""
        if self._file < 0 or not select.select([self._file], [], [], 0.0)[0]:
            return ""
        first = os.read(self._file, 1).decode(errors="replace")
        if first != "\x1b" or not select.select([self._file], [], [], 0.0)[0]:
            return first
        return first + os.read(self._file, 2).decode(errors="replace")


def draw(text: str) -> None:
    """Draw a line in the place of the last one, where standard error is a terminal."""
    if sys.stderr.isatty():
        width = shutil.get_terminal_size().columns - 1
        print(f"{LINE}{text[:width]}", end="", file=sys.stderr, flush=True)


def clear() -> None:
    """Remove the line."""
    draw("")
