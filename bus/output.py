"""Output ports."""

import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

import zenoh
from zenoh.handlers import Callback

from bus.counters import Meter, OutputStatistics
from bus.encoder import Encoder
from bus.envelope import WALL, Envelope, new_source
from bus.errors import BusError, WireError
from bus.names import key_of
from bus.schema import fields_of, type_name

MAX_MESSAGE = 65536  # bytes of one message, unless a port is opened with another limit


class Output:
    """Writes messages of one type under one name, never waiting for a reader.

    An output whose name ends in ``:o`` owns it and writes nothing until the claim
    stands. One on an input's name (``:i``) writes directly to that input, beside
    other writers, and owns nothing.
    """

    direction = "output"

    def __init__(
        self,
        session: zenoh.Session,
        name: str,
        message_type: type,
        rate: float = 0.0,
        model: str = "",
        dimensions: Mapping[str, int] | None = None,
        reliable: bool = False,
        max_message: int = MAX_MESSAGE,
        now: Callable[[], tuple[int, int]] | None = None,
    ):
        self.name = name
        self.type = message_type
        self.rate = rate
        self.sources: tuple[str, ...] = ()
        self.source = new_source()
        self.epoch = 0
        self.statistics = OutputStatistics()
        self.owned = name.endswith(":o")
        self.standing = not self.owned
        self.matched = False
        self._encoder = Encoder(message_type, self.source, self.epoch, model, dimensions)
        self._max_message = max_message
        self._seq = 0
        self._now = now or (lambda: (time.time_ns(), WALL))
        self._lock = threading.Lock()
        self._meter = Meter()
        self._publisher = _publisher(session, name, reliable)
        self._listener = self._publisher.declare_matching_listener(
            Callback(self._on_matching, indirect=False)
        )
        status: Any = self._publisher.matching_status  # its stub says bool
        self.matched = self.matched or status.matching

    def write(
        self,
        data: Any,
        *,
        like: Envelope | None = None,
        stamp: int | None = None,
        clock: int | None = None,
        acquired: int | None = None,
        valid: bool = True,
        reason: str = "",
    ) -> None:
        """Write one message; raise WireError when the data break their type.

        ``like`` copies stamp, clock and acquired from the envelope that the data
        derive from; what is given besides wins. Without any, the measurement is of
        now. Times in ns.
        """
        if not self.standing:
            raise BusError(
                f"{self.name}: nothing is written before node.ready(), or after losing it"
            )
        sent = time.time_ns()
        if like is not None:
            stamp = like.stamp if stamp is None else stamp
            clock = like.clock if clock is None else clock
            acquired = like.acquired if acquired is None else acquired
        elif stamp is None:
            stamp, clock = self._now()
        acquired = sent if acquired is None else acquired
        with self._lock:
            message = self._encoder.encode(
                data, self._seq + 1, stamp, clock or WALL, acquired, sent, valid, reason
            )
            if len(message) > self._max_message:
                raise WireError(f"{self.name}: {len(message)} bytes, limit {self._max_message}")
            self._seq += 1
            self._publisher.put(message)
        self.statistics.written += 1
        self.statistics.bytes += len(message)

    def info(self) -> dict[str, Any]:
        """Return what `bus.introspection.port_info` shows."""
        return {
            "fields": [field.describe() for field in fields_of(self.type)],
            "description": self.type.__doc__ or "",
            "statistics": self.statistics.as_map(),
            "hz": self._meter.rate(self.statistics.written),
            "matched": self.matched,
        }

    @property
    def type_name(self) -> str:
        """Name and version of the message type."""
        return type_name(self.type)

    def stand(self) -> None:
        """The name is ours: write from now on."""
        self.standing = True

    def fall(self) -> None:
        """The name is lost: write nothing any more."""
        self.standing = False

    def close(self) -> None:
        """Write no more."""
        self.fall()
        self._listener.undeclare()
        self._publisher.undeclare()

    def _on_matching(self, status: zenoh.MatchingStatus) -> None:
        self.matched = status.matching


def _publisher(session: zenoh.Session, name: str, reliable: bool) -> zenoh.Publisher:
    """Return a publisher that drops what a full link cannot take, or waits at most 20 ms."""
    control, priority = zenoh.CongestionControl.DROP, zenoh.Priority.REAL_TIME
    if reliable:  # of its own priority, so that it cannot stall the others
        control, priority = zenoh.CongestionControl.BLOCK, zenoh.Priority.INTERACTIVE_HIGH
    return session.declare_publisher(
        key_of(name), congestion_control=control, priority=priority, express=True
    )
