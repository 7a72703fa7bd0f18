"""Is the last message still worth something?"""

import time
from collections.abc import Callable, Sequence

from bus.clock import SessionClock
from bus.envelope import Received

PERIODS = 10  # a stream is stale after so many nominal periods without a message ...
LEAST = 0.02  # ... but not before this many seconds
LATE = 0.1  # s beyond the usual delay after which a message is old news, though it has just come
TOO_LATE = 1.0  # s beyond it after which nobody wants to read it
_MEMORY = 5_000_000_000  # ns; the usual delay is the least of the last one or two of these


class Lateness:
    """How much longer than usual the last message took from writer to reader.

    After a stop of the reader, or on a slow link, messages come in good number and
    are old all the same. Writer and reader may have different clocks, so only the
    difference to the least delay counts. A clock that is set back begins anew.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self._source, self._sent = b"", 0
        self._least = self._before = 0
        self._renewal = 0

    def arrived(self, source: bytes, sent: int, arrival: int) -> None:
        """Note a message; times in ns, each of one clock."""
        delay = arrival - sent
        if source != self._source or sent < self._sent:
            self._source, self._least, self._before = source, delay, delay
            self._renewal = arrival + _MEMORY
        elif arrival > self._renewal:
            self._before, self._least = self._least, delay
            self._renewal = arrival + _MEMORY
        elif delay < self._least:
            self._least = delay
        self._sent = sent
        self.seconds = (delay - min(self._least, self._before)) * 1e-9


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
        self.names = names  # of the ports that are read
        self._clock = clock
        self._exists = exists
        self._arrival = 0  # monotonic [ns], 0 before the first
        self._came = 0  # likewise, of what is too late, too
        self._opened = time.monotonic_ns()
        self._lateness = Lateness()

    def arrived(self, received: Received) -> bool:
        """Note a message; return whether it is worth reading.

        What comes very late was kept for us by the system while we were stopped: fresh
        data are behind it.
        """
        envelope, self._came = received.envelope, received.arrival
        self._lateness.arrived(envelope.source, envelope.sent, received.arrival)
        if self._lateness.seconds > TOO_LATE and not self._clock.lockstep:
            return False
        self._arrival = received.arrival
        return True

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
        return not self.limit or (self._age() <= self.limit and not self._late)

    @property
    def _late(self) -> bool:
        return self._lateness.seconds > max(self.limit, LATE)

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
        name = " or ".join(self.names)
        if self._late and (time.monotonic_ns() - self._came) * 1e-9 <= self.limit:
            return f"data on {name} come {self._lateness.seconds * 1e3:.0f} ms late"
        if self._arrival:
            return f"no data on {name} for {self.silence * 1e3:.0f} ms"
        if not any(map(self._exists, self.names)):
            return f"nobody writes {name}"
        return f"no data on {name} yet"
