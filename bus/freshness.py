"""Is the last message still worth something?"""

import time
from collections.abc import Callable, Sequence

from bus.clock import SessionClock
from bus.envelope import Received

PERIODS = 10  # a stream is stale after so many nominal periods without a message ...
LEAST = 0.02  # ... but not before this many seconds
LATE = 0.1  # s beyond the usual delay after which a message is old news, though it has just come
TOO_LATE = 1.0  # s beyond it after which nobody wants to read it
WRITERS = 16  # whose usual delays are kept, for an input that reads several
_MEMORY = 5_000_000_000  # ns; the usual delay is the least of the last one or two of these


class Lateness:
    """How much longer than usual the last message took from its writer to the reader.

    After a stop of the reader, or on a slow link, messages come in good number and
    are old all the same. Writer and reader may have different clocks, so only the
    difference to the writer's least delay counts; but on one machine a new writer's
    first message, which may have waited too, is compared with the clock itself.

    Args:
        is_here: Tells of a writer's source whether it is on our machine.
    """

    def __init__(self, is_here: Callable[[bytes], bool] = lambda source: False) -> None:
        self.seconds = 0.0
        self._is_here = is_here
        self._usual: dict[bytes, _UsualDelay] = {}

    def arrived(self, source: bytes, sent: int, arrival: int) -> None:
        """Note a message; times in ns, each of one clock."""
        delay = arrival - sent
        usual = self._usual.get(source)
        if usual is None:
            usual = self._usual[source] = self._begin(source, delay, arrival)
        usual.note(sent, delay, arrival)
        self.seconds = (delay - usual.least) * 1e-9

    def _begin(self, source: bytes, delay: int, arrival: int) -> "_UsualDelay":
        if len(self._usual) == WRITERS:
            del self._usual[next(iter(self._usual))]
        if self._is_here(source):
            delay = min(delay, time.monotonic_ns() - time.time_ns())
        return _UsualDelay(delay, arrival)


class _UsualDelay:
    """The least delay [ns] of a writer's last messages. A clock that is set back begins anew."""

    def __init__(self, delay: int, arrival: int):
        self._sent = 0
        self._begin(delay, arrival)

    def _begin(self, delay: int, arrival: int) -> None:
        self._last = self._before = delay
        self._renewal = arrival + _MEMORY

    @property
    def least(self) -> int:
        return min(self._last, self._before)

    def note(self, sent: int, delay: int, arrival: int) -> None:
        if sent < self._sent:
            self._begin(delay, arrival)
        elif arrival > self._renewal:
            self._before, self._last = self._last, delay
            self._renewal = arrival + _MEMORY
        elif delay < self._last:
            self._last = delay
        self._sent = sent


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
        is_here: Callable[[str, bytes], bool] = lambda name, source: False,
    ):
        self.limit = max(PERIODS / rate, LEAST) if rate else 0.0  # s
        self.names = names  # of the ports that are read
        self._clock = clock
        self._exists = exists
        self._arrival = 0  # monotonic [ns], 0 before the first
        self._came = 0  # likewise, of what is too late, too
        self._opened = time.monotonic_ns()
        self._lateness = Lateness(lambda source: any(is_here(n, source) for n in self.names))

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
        now = self._clock.paused_at or time.monotonic_ns()
        return (now - max(self._arrival, self._clock.resumed_at)) * 1e-9

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
