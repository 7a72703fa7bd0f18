"""Progress bars; on standard error, where that is a terminal."""

import time

from deploy.terminal import clear, draw

WIDTH = 30
REDRAW = 0.1  # s


def bar(share: float) -> str:
    """Return a bar, filled up to a share of 0 to 1."""
    filled = round(WIDTH * min(1.0, share))
    return f"[{'#' * filled}{'-' * (WIDTH - filled)}]"


class ProgressBar:
    """How much of a log is done, and how many times faster than real time.

    Args:
        size: Samples of the log.
        period: Time between them [s].
    """

    def __init__(self, size: int, period: float):
        self._size, self._period = size, period
        self._begin = time.monotonic()
        self._drawn = 0.0

    def show(self, done: int) -> None:
        """Draw the bar when it is time to; ``done`` samples are."""
        if (now := time.monotonic()) - self._drawn >= REDRAW:
            self._drawn = now
            draw(self.text(done, now - self._begin))

    def text(self, done: int, elapsed: float) -> str:
        """Return the bar after some seconds."""
        share, speed = done / self._size, done * self._period / max(elapsed, 1e-9)
        return f"{bar(share)} {100.0 * share:.0f} %  {speed:.1f} x real time"

    def end(self) -> None:
        """Remove the bar."""
        clear()
