"""How simulated time follows wall time."""


class RealTime:
    """Ticks that are due in real time, with bounded catch-up.

    After a stall of the machine the plant catches up by at most ``burst`` ticks per
    wake; what is beyond is given up and counted, so that simulated time slips
    instead of the readers being flooded.

    Args:
        tick: Wall time of a tick [ns].
        burst: Most ticks per wake.

    Attributes:
        slipped: Ticks given up so far.
    """

    def __init__(self, tick: int, burst: int = 10):
        self._tick = tick
        self._burst = burst
        self._next = 0
        self.slipped = 0

    def start(self, now: int) -> None:
        """Begin, or begin again after a pause: the first tick is due one tick from now."""
        self._next = now + self._tick

    def change(self, tick: int, now: int) -> None:
        """Go on with another wall time of a tick [ns]; what is due is given up."""
        if tick != self._tick:
            self._tick = tick
            self.start(now)

    def due(self, now: int) -> int:
        """Return how many ticks to take at a monotonic time [ns]."""
        behind = (now - self._next) // self._tick + 1
        if behind <= 0:
            return 0
        ticks = min(behind, self._burst)
        self.slipped += behind - ticks
        self._next += behind * self._tick
        return ticks

    def remaining(self, now: int) -> float:
        """Return the seconds until the next tick, never negative."""
        return max(0, self._next - now) * 1e-9


class SlipWatch:
    """Notices, once per period, that the machine is too slow for real time.

    Args:
        period: Between looks [ns].
        share: Of the ticks given up in a period above which it is worth a word.
    """

    def __init__(self, period: int = 10_000_000_000, share: float = 0.1):
        self._period, self._share = period, share
        self._due = self._ticks = self._slipped = 0

    def lost(self, now: int, ticks: int, slipped: int) -> float:
        """Return the share of ticks given up lately when it is large, else 0.

        Args:
            now: Monotonic time [ns].
            ticks, slipped: Ticks taken and given up since the start.
        """
        if now < self._due:
            return 0.0
        first = self._due == 0
        taken, given_up = ticks - self._ticks, slipped - self._slipped
        self._due, self._ticks, self._slipped = now + self._period, ticks, slipped
        share = given_up / max(1, taken + given_up)
        return 0.0 if first or share < self._share else share
