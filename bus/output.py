"""Output ports."""

import threading
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import zenoh

from bus.counters import Meter, OutputStatistics
from bus.encoder import Encoder
from bus.envelope import WALL, Envelope, new_source
from bus.errors import BusError, WireError
from bus.names import key_of, stream_key
from bus.schema import fields_of, type_name
from bus.stream import THINNED_HZ, BundledStream, Stream, ThinnedStream

Times = tuple[int, int, int, int]  # stamp, clock, acquired, sent
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
        self._encode_in = partial(
            Encoder, message_type, self.source, model=model, dimensions=dimensions
        )
        self._encoder = self._encode_in(self.epoch)
        self._max_message, self._model = max_message, model
        self._reliable = reliable
        self._now = now or (lambda: (time.time_ns(), WALL))
        self._lock = threading.Lock()
        self._meter = Meter()
        self._stream = Stream(session, key_of(name), reliable, large=max_message > MAX_MESSAGE)
        self._thinned = ThinnedStream(session, stream_key(name, "thinned")) if self.owned else None
        self._bundled = BundledStream(session, stream_key(name, "bundled")) if self.owned else None

    @property
    def matched(self) -> bool:
        """Whether anybody reads every message."""
        bundled = self._bundled
        return self._stream.matched or (bundled is not None and bundled.matched)

    @property
    def heard(self) -> bool:
        """Whether anybody reads any of it."""
        return self.matched or (self._thinned is not None and self._thinned.matched)

    def wanted(self, stamp: int, valid: bool = True) -> bool:
        """Whether anybody would read a message of this stamp [ns]."""
        thinned = self._thinned
        return self.matched or (thinned is not None and thinned.due(stamp, valid))

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
        sent = time.time_ns()
        if like is not None:
            stamp = like.stamp if stamp is None else stamp
            clock = like.clock if clock is None else clock
            acquired = like.acquired if acquired is None else acquired
        elif stamp is None:
            stamp, clock = self._now()
        acquired = sent if acquired is None else acquired
        times = stamp, clock or WALL, acquired, sent
        with self._lock:
            if not self.standing:
                raise BusError(
                    f"{self.name}: nothing is written before node.ready(), or after losing it"
                )
            message = self._encode(self._stream, data, times, valid, reason)
            self._stream.put(message)
            self._put_aside(message, data, times, valid, reason)
        self.statistics.written += 1
        self.statistics.bytes += len(message)

    def _put_aside(self, message: bytes, data: Any, times: Times, valid: bool, reason: str) -> None:
        """Serve those who do not read the whole stream, one message at a time."""
        thinned, bundled, stamp = self._thinned, self._bundled, times[0]
        if bundled is not None and (bundled.matched or bundled.waiting):
            bundled.add(message, stamp, valid)
        if thinned is not None and thinned.matched and thinned.due(stamp, valid):
            thinned.put(self._encode(thinned, data, times, valid, reason))
            thinned.take(stamp)

    def _encode(self, stream: Stream, data: Any, times: Times, valid: bool, reason: str) -> bytes:
        message = self._encoder.encode(data, stream.seq + 1, *times, valid, reason)
        if len(message) > self._max_message:
            raise WireError(f"{self.name}: {len(message)} bytes, limit {self._max_message}")
        return message

    def info(self) -> dict[str, Any]:
        """Return what `bus.introspection.port_info` shows."""
        return {
            "fields": [field.describe() for field in fields_of(self.type)],
            "description": self.type.__doc__ or "",
            "statistics": self.statistics.as_map(),
            "hz": self._meter.rate(self.statistics.written),
            "wanted_hz": self._wanted_hz(),
            "max_message": self._max_message,
            "model": self._model,
            "reliable": self._reliable,
        }

    @property
    def type_name(self) -> str:
        """Name and version of the message type."""
        return type_name(self.type)

    def stand(self) -> None:
        """The name is ours: write from now on, in the epoch in which it was claimed."""
        if self.epoch:
            self._encoder = self._encode_in(self.epoch)
        self.standing = True

    def fall(self) -> None:
        """The name is lost: write nothing any more."""
        self.standing = False

    def close(self) -> None:
        """Write no more."""
        with self._lock:  # not under a thread that writes
            self.fall()
            for stream in (self._stream, self._thinned, self._bundled):
                if stream is not None:
                    stream.close()

    def _wanted_hz(self) -> float:
        """The nominal rate, less where only a thinned stream is read, 0 while nobody reads."""
        if self.matched:
            return self.rate
        return min(self.rate, THINNED_HZ) if self.heard else 0.0
