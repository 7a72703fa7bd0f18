"""Loops with a rate, and a limit to their waiting."""

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import repeat
from typing import Any


class Pace:
    """Iterates at a rate [Hz] on an absolute schedule; yields the time of each start [ns].

    Who is late starts at once, and the schedule is not caught up with. Without a count the
    loop has no end.
    """

    def __init__(self, rate: float, count: int | None = None):
        self._period = round(1e9 / rate)
        self._turns = repeat(None) if count is None else repeat(None, count)

    def __iter__(self) -> Iterator[int]:
        due = time.monotonic_ns()
        for _ in self._turns:
            due += self._period
            rest = due - time.monotonic_ns()
            if rest > 0:
                time.sleep(1e-9 * rest)
            now = time.monotonic_ns()
            due = max(due, now - self._period)
            yield now


@contextmanager
def alarm(seconds: float) -> Iterator[None]:
    """Raise TimeoutError when the block takes longer; in the main thread only."""

    def ring(*_: Any) -> None:
        raise TimeoutError(f"not within {seconds:g} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def wait_until(condition: Callable[[], bool], timeout: float = 30.0) -> None:
    """Return when a condition holds; raise TimeoutError when it does not in time [s]."""
    deadline = time.monotonic() + timeout
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(f"not within {timeout:g} s: {condition}")
        time.sleep(0.002)
