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
