"""A loop with a fixed period on an absolute schedule, which does not drift."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bus.node import Node


@dataclass
class PeriodicStatistics:
    """Measured periods and lateness of a loop, in seconds."""

    cycles: int = 0
    overruns: int = 0  # deadlines that had passed before the wait
    slipped: float = 0.0  # time given up because it could not be caught up
    late: float = 0.0  # latest wake-up after its deadline
    worst: float = 0.0  # worst wake-up after its deadline
    period: float = 0.0  # mean since the start
    squares: float = 0.0  # sum of the squared latenesses [s2]

    @property
    def jitter(self) -> float:
        """Root mean square of the wake-ups after their deadlines."""
        return math.sqrt(self.squares / self.cycles) if self.cycles else 0.0

    def report(self) -> dict[str, Any]:
        """Return the figures as plain values, as a service's ``status`` shows them."""
        return {
            "cycles": self.cycles,
            "period_s": self.period,
            "jitter_s": self.jitter,
            "worst_s": self.worst,
            "overruns": self.overruns,
            "slipped_s": self.slipped,
        }


class Periodic:
    """Waits for the next deadline; late cycles are caught up, but not more than ``catch_up``.

    Args:
        period: Between two deadlines [s]; may be changed between two cycles.
        catch_up: Cycles.
        wait: Called with the seconds until the deadline; may return early.
        now: Time [s]. A time that jumps back begins a new schedule.
        running: Once False, nothing is waited for any more.
    """

    def __init__(
        self,
        period: float,
        catch_up: int = 10,
        wait: Callable[[float], object] = time.sleep,
        now: Callable[[], float] = time.monotonic,
        running: Callable[[], bool] = lambda: True,
    ):
        if period <= 0.0:
            raise ValueError(f"period must be positive, got {period} s")
        self.period = period
        self.statistics = PeriodicStatistics()
        self._catch_up = catch_up
        self._wait, self._now, self._running = wait, now, running
        self._started = self._deadline = now()

    @classmethod
    def of(cls, node: "Node", period: float) -> "Periodic":
        """Return the loop of a service; its ``status`` tells how the loop keeps time.

        Requests are answered while it waits. Where the node follows a clock port, the
        period is one of simulated time, and nothing is due while the clock is paused.
        """
        now = (lambda: node.clock.time * 1e-9) if node.clock.simulated else time.monotonic
        loop = cls(period, wait=node.wait, now=now, running=lambda: node.running)
        status = lambda: node.status() | {"loop": loop.statistics.report()}  # noqa: E731
        node.verb("status", status, "state of this service and of its loop")
        return loop

    def reset(self) -> None:
        """Begin a new schedule now, after a pause for instance."""
        self._started = self._deadline = self._now()
        self.statistics = PeriodicStatistics()

    def next(self) -> bool:
        """Wait until the next deadline; return at once when it has passed.

        Returns False when the loop is to end.
        """
        self._deadline += self.period
        statistics, late = self.statistics, self._now() - self._deadline
        if late > 0.0:
            statistics.overruns += 1
            self._give_up(late)
        if not self._until_deadline():
            return False
        now = self._now()
        statistics.cycles += 1
        statistics.late = now - self._deadline
        statistics.squares += statistics.late**2
        statistics.worst = max(statistics.worst, statistics.late)
        statistics.period = (now - self._started) / statistics.cycles
        return True

    def _until_deadline(self) -> bool:
        while (running := self._running()) and (remaining := self._deadline - self._now()) > 0.0:
            if remaining > 1.001 * self.period:  # the time has jumped back
                jump = remaining - self.period
                self._deadline -= jump
                self._started -= jump
                remaining = self.period
            self._wait(remaining)
        return running

    def _give_up(self, late: float) -> None:
        excess = late - self._catch_up * self.period
        if excess > 0.0:
            self._deadline += excess
            self.statistics.slipped += excess
