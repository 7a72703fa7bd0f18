"""Loops that take the newest message of a stream at a rate of their own."""

import time
from collections.abc import Callable
from typing import Any

from bus.envelope import Envelope
from bus.input import Input, Received
from bus.node import Node
from bus.rhythm import Rhythm
from bus.stream import THINNED_HZ

WAIT = 0.01  # s; silence is looked at this often in lockstep, where messages wake the loop
COMPLAINT = 0.02  # s between messages while a stream is silent


class Complaint:
    """Says why there is nothing, but not at every look."""

    def __init__(self, say: Callable[[str], None], period: float = COMPLAINT):
        self._say, self._period, self._said = say, period, 0.0

    def make(self, reason: str) -> None:
        """Say it, unless something was said within the period [s]."""
        now = time.monotonic()
        if now - self._said >= self._period:
            self._said = now
            self._say(reason)


def paced(rate: float, lockstep: bool) -> dict[str, Any]:
    """Return how ``Node.input`` opens what such a loop reads; ``rate`` in Hz."""
    whole = lockstep or rate > THINNED_HZ
    return {"polled": not lockstep, "stream": "whole" if whole else "thinned"}


class PacedLoop:
    """Follows one stream, and acknowledges its stamps.

    Args:
        node, stream: Whose, and which.
        rate: How often a message is due [Hz], by its stamps.
        lockstep: Whether every message is waited for.
        due: Called with a message that is due, valid or not.
        restart: Called when the stamps jump back.
        silent: Called with the reason, 50 times a second, while nothing comes.
    """

    last: Envelope | None = None  # of the newest message

    def __init__(
        self,
        node: Node,
        stream: Input,
        rate: float,
        lockstep: bool,
        due: Callable[[Received], None],
        restart: Callable[[], None],
        silent: Callable[[str], None],
    ):
        self._node, self._stream, self._lockstep = node, stream, lockstep
        self._due, self._restart, self._complaint = due, restart, Complaint(silent)
        self._period, self._next = int(1e9 / rate), 0  # ns
        self._rhythm, self._found = Rhythm(1.0 / rate), False

    def spin(self) -> None:
        """Wait for a message, and pass it on when one is due."""
        self._node.wait(WAIT if self._lockstep else self._rhythm.rest(self._found))
        sample = self._stream.newest()
        self._found = sample is not None
        if sample is not None:
            self._take(sample)
        if not self._stream.fresh:
            self._complaint.make(self._stream.reason)

    def _take(self, sample: Received) -> None:
        envelope, last = sample.envelope, self.last
        repeated = last is not None and envelope.stamp == last.stamp
        if last is not None and envelope.stamp < last.stamp:
            self._restart()
            self._next = 0
        self.last = envelope
        if envelope.stamp >= self._next:
            self._next = (envelope.stamp // self._period + 1) * self._period
            self._due(sample)
        elif repeated and not envelope.valid:  # nothing new comes, and somebody says why
            self._complaint.make(envelope.reason)
        self._node.acknowledge(envelope.stamp)
