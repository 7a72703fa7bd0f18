"""Is the last message still worth something?"""

import time
from collections.abc import Callable, Sequence

from bus.clock import SessionClock
from bus.envelope import Received

PERIODS = 10  # a stream is stale after so many nominal periods without a message ...
LEAST = 0.02  # ... but not before this many seconds


class Freshness:
    """Age of an input's stream, by arrival on the monotonic clock.

    A paused clock stops the ageing: the plant stands still, its data do not rot. In
    lockstep wall time means nothing, only a silent clock does. Without a nominal
    rate the messages are events, which do not age.
    """

    def __init__(
        self,
        names: Sequence[str],
        rate: float,
        clock: SessionClock,
        exists: Callable[[str], bool],
    ):
        self.limit = max(PERIODS / rate, LEAST) if rate else 0.0  # s
        self._names = names
        self._clock = clock
        self._exists = exists
        self._arrival = 0  # monotonic [ns], 0 before the first
        self._opened = time.monotonic_ns()

    def arrived(self, received: Received) -> None:
        """Note a message."""
        self._arrival = received.arrival

    @property
    def silence(self) -> float:
        """Seconds since the last message; since opening before the first."""
        return (time.monotonic_ns() - (self._arrival or self._opened)) * 1e-9

    @property
    def fresh(self) -> bool:
        """Whether the stream flows."""
        if not self._arrival:
            return False
        if self._clock.lockstep and self._clock.alive:
            return True
        return not self.limit or self._age() <= self.limit

    def _age(self) -> float:
        """Seconds since the last message, not counting the time that the clock stood paused."""
        if self._clock.resumed_at > self._arrival:
            return (time.monotonic_ns() - self._clock.resumed_at) * 1e-9
        now = self._clock.paused_at or time.monotonic_ns()
        return (now - self._arrival) * 1e-9

    @property
    def reason(self) -> str:
        """Why the stream is not fresh, or nothing."""
        if self.fresh:
            return ""
        name = " or ".join(self._names)
        if self._arrival:
            return f"no data on {name} for {self.silence * 1e3:.0f} ms"
        if not any(map(self._exists, self._names)):
            return f"nobody writes {name}"
        return f"no data on {name} yet"
