"""When to look at polled inputs: just after a message has come, and seldom in vain."""

import time
from collections.abc import Callable

FOUND = 0.97  # of a period until the next look; the looks drift towards the arrivals ...
MISSED = 0.2  # ... until one comes too early, and is repeated soon
SILENT = 3  # looks in vain after which there is no rhythm to find


class Rhythm:
    """Locks a loop onto the arrivals of a periodic stream that does not wake it.

    Looking at a fixed faster rate would find nothing at every third look, and waking
    costs more than looking. Where messages come slower than their rate says, or not
    at all, the loop looks once per period.

    Args:
        period: Of the stream, or of the loop where the stream is faster [s].
    """

    def __init__(self, period: float, now: Callable[[], float] = time.monotonic):
        self._period = period
        self._now = now
        self._looked = now()  # or is about to look
        self._misses = 0

    def rest(self, found: bool) -> float:
        """Return how long to wait until the next look [s].

        Args:
            found: Whether the last look found a message.
        """
        self._misses = 0 if found else self._misses + 1
        share = FOUND if found else MISSED if self._misses < SILENT else 1.0
        now = self._now()
        self._looked = max(self._looked + share * self._period, now)
        return self._looked - now
