"""A loop with a fixed period on an absolute schedule, which does not drift."""

import time
from collections.abc import Callable
from dataclasses import dataclass


@dataclass
class PeriodicStatistics:
    """Measured periods and lateness of a loop, in seconds."""

    cycles: int = 0
    overruns: int = 0  # deadlines that had passed before the wait
    slipped: float = 0.0  # time given up because it could not be caught up
    jitter: float = 0.0  # latest wake-up after its deadline
    worst: float = 0.0  # worst wake-up after its deadline
    period: float = 0.0  # mean since the start


class Periodic:
    """Waits for the next deadline; late cycles are caught up, but not more than ``catch_up``."""

    def __init__(
        self,
        period: float,
        catch_up: int = 10,
        wait: Callable[[float], object] = time.sleep,
        now: Callable[[], float] = time.monotonic,
    ):
        if period <= 0.0:
            raise ValueError(f"period must be positive, got {period} s")
        self.period = period
        self.statistics = PeriodicStatistics()
        self._catch_up = catch_up * period
        self._wait, self._now = wait, now
        self._started = self._deadline = now()

    def reset(self) -> None:
        """Begin a new schedule now, after a pause for instance."""
        self._started = self._deadline = self._now()
        self.statistics = PeriodicStatistics()

    def next(self) -> None:
        """Wait until the next deadline; return at once when it has passed."""
        self._deadline += self.period
        statistics, late = self.statistics, self._now() - self._deadline
        if late > 0.0:
            statistics.overruns += 1
            self._give_up(late)
        while (remaining := self._deadline - self._now()) > 0.0:
            self._wait(remaining)
        now = self._now()
        statistics.cycles += 1
        statistics.jitter = now - self._deadline
        statistics.worst = max(statistics.worst, statistics.jitter)
        statistics.period = (now - self._started) / statistics.cycles

    def _give_up(self, late: float) -> None:
        excess = late - self._catch_up
        if excess > 0.0:
            self._deadline += excess
            self.statistics.slipped += excess
