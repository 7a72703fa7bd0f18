"""Input ports."""

import logging
import time
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import zenoh

from bus.counters import InputStatistics, Meter
from bus.decoder import Decoder
from bus.directory import Directory
from bus.envelope import Received, new_source
from bus.errors import BusError, WireError
from bus.freshness import Freshness
from bus.names import StreamKind, check_name, key_of, stream_key
from bus.output import MAX_MESSAGE
from bus.receivers import Delivery, Poll, Receiver
from bus.sample_queue import SampleQueue
from bus.schema import fields_of, type_name
from bus.waiter import Waiter

logger = logging.getLogger(__name__)

BREATH = 0.1  # s of reading without an end
REST = 0.05  # s without reading, after which it begins anew


class Input:
    """The newest ``depth`` messages of its source ports, and of writers to its own key.

    Messages stay undecoded until read, so one that is pushed out costs nothing. Of a
    source port only the owner of the name is heard. Bad messages are counted, logged
    at most once per second, and skipped.
    """

    direction = "input"

    def __init__(
        self,
        session: zenoh.Session,
        name: str,
        message_type: type,
        directory: Directory,
        waiter: Waiter,
        freshness: Freshness,
        sources: Sequence[str] = (),
        depth: int = 1,
        rate: float = 0.0,
        model: str = "",
        dimensions: Mapping[str, int] | None = None,
        max_message: int = MAX_MESSAGE,
        polled: bool = False,
        stream: StreamKind = "whole",
    ):
        if depth < 1:
            raise ValueError(f"{name}: depth must be at least 1, got {depth}")
        self.name = name
        self.type = message_type
        self.rate = rate
        self.sources = tuple(sources)
        self.source = new_source()
        self.epoch = 0
        self.latest: Received | None = None
        self._statistics = InputStatistics()
        self._decoder = Decoder(message_type, model, dimensions)
        self._directory = directory
        self._freshness = freshness
        self._samples = SampleQueue(depth)
        self._max_message, self._model = max_message, model
        self._complained = 0.0
        self._waiter, self._waits = waiter, 0
        self._reading_since = self._read_at = 0.0  # monotonic [s]
        self._explained = 0
        self._meter = Meter()
        if stream == "bundled" and not polled:
            raise ValueError(f"{name}: only a polled input can read a bundled stream")
        self._stream: StreamKind = stream
        self._polled, self._resting, self._depth = polled, False, depth
        self._receive = partial(self._receiver, session, waiter)
        self._own = self._receive(key_of(name), None)
        self._receivers = {each: self._receive_from(each) for each in self.sources}
        self._read_from(*self._receivers)

    def read(self) -> Received | None:
        """Return the next message, or None when there is none; bad ones are skipped.

        Of a stream that comes faster than it is handled, it says None now and then, so
        that a loop that reads all gets to its requests and hears that it shall end.
        """
        if self._is_breathless():
            return None
        while (item := self._samples.pop() or self._poll()) is not None:
            received = self._accept(*item)
            if received is None:
                continue
            # when a polled message came is not known, so it cannot be called late
            if self._freshness.arrived(received) or self._polled:
                self.latest = received
                self._statistics.received += 1
                return received
            self._statistics.late += 1
        self._waits = -1  # all was read
        return None

    def _is_breathless(self) -> bool:
        """Whether the loop has been reading for long, without a wait or a rest."""
        now, waits = time.monotonic(), self._waiter.waits
        if waits != self._waits or now - self._read_at > REST:
            self._waits, self._reading_since = waits, now
        self._read_at = now
        if waits == 0 or now - self._reading_since <= BREATH:
            return False
        self._reading_since = now
        return True

    def newest(self) -> Received | None:
        """Return the newest of all waiting messages, or None when nothing new came."""
        newest = None
        while (received := self.read()) is not None:
            newest = received
        return newest

    def connect(self, source: str) -> None:
        """Read one port more; nothing changes when it is read already."""
        if source not in self._receivers:
            self._receivers[source] = self._receive_from(check_name(source))
            self._read_from(*self._receivers)

    def disconnect(self, source: str) -> None:
        """Read a port no more; raise BusError when it is not read."""
        receiver = self._receivers.pop(source, None)
        if receiver is None:
            listed = ", ".join(self.sources) or "nothing"
            raise BusError(f"{self.name} does not read {source}; it reads {listed}")
        receiver.close()
        self._read_from(*self._receivers)

    @property
    def fresh(self) -> bool:
        """Whether the last message read came within max(10 / rate, 20 ms)."""
        return self._freshness.fresh

    @property
    def silence(self) -> float:
        """Seconds since the last message read came; since opening before the first."""
        return self._freshness.silence

    @property
    def reason(self) -> str:
        """Why the input is not fresh, or nothing."""
        return self._freshness.reason

    @property
    def statistics(self) -> InputStatistics:
        """What happened to the messages so far."""
        self._statistics.dropped = self._samples.dropped
        return self._statistics

    def info(self) -> dict[str, Any]:
        """Return what `bus.introspection.port_info` shows."""
        return {
            "fields": [field.describe() for field in fields_of(self.type)],
            "description": self.type.__doc__ or "",
            "statistics": self.statistics.as_map(),
            "hz": self._meter.rate(self._statistics.received),
            "fresh": self.fresh,
            "reason": self.reason,
            "max_message": self._max_message,
            "model": self._model,
            "queue": {"depth": self._depth, "mode": "fifo" if self._depth > 1 else "newest"},
            "stream": self._stream,
        }

    @property
    def type_name(self) -> str:
        """Name and version of the message type."""
        return type_name(self.type)

    def rest(self, resting: bool) -> None:
        """Stop reading the source ports of a polled input, or go on; its own key is always read.

        What is missed meanwhile is not counted as lost.
        """
        self._resting = resting
        for receiver in self._receivers.values():
            receiver.rest(resting)

    def stand(self) -> None:
        """The name is ours; an input reads without it too."""

    def fall(self) -> None:
        """The name is lost."""

    def close(self) -> None:
        """Receive no more; threads end."""
        for receiver in self._all:
            receiver.close()

    def _receive_from(self, source: str) -> Poll | Delivery:
        receiver = self._receive(stream_key(source, self._stream), source)
        receiver.rest(self._resting)
        return receiver

    def _receiver(
        self, session: zenoh.Session, waiter: Waiter, key: str, origin: str | None
    ) -> Poll | Delivery:
        arguments = session, self._directory, key, origin, self._samples, self._max_message
        if self._polled:
            return Poll(*arguments, ring=self._depth, bundled=self._stream == "bundled")
        return Delivery(*arguments, wake=waiter.wake)

    def _read_from(self, *sources: str) -> None:
        self._all = [self._own, *self._receivers.values()]
        self.sources = sources
        self._freshness.names = sources or (self.name,)

    def _poll(self) -> tuple | None:
        if not self._polled:
            return None
        for receiver in self._all:
            receiver.collect()
        return self._samples.pop()

    def _accept(
        self,
        payload: Any,
        arrival: int,
        receiver: Receiver,
        leader: bytes | None,
        overrun: bool,
    ) -> Received | None:
        statistics, origin = self._statistics, receiver.origin
        try:
            if type(payload) is int:
                raise WireError(f"{payload} bytes, limit {self._max_message}")
            data, envelope = self._decoder.decode(payload)
        except WireError as error:
            statistics.refused += 1
            self._complain(f"refused: {error}")
            return None
        source = envelope.source
        if origin is not None and source != leader and source != self._directory.leader(origin):
            statistics.foreign += 1
            self._complain(f"ignored: its writer does not own {origin}")
            return None
        gap = receiver.sequences.gap(source, envelope.seq)
        if gap < 0:
            statistics.repeated += 1
            return None
        if gap:
            self._count_missing(gap, overrun)
        else:
            self._explained = self._samples.passed + statistics.refused
        return Received(data, envelope, arrival)

    def _count_missing(self, gap: int, overrun: bool) -> None:
        # what this queue dropped and what was refused explains a part of the gap
        explained = self._samples.passed + self._statistics.refused
        missing = gap - (explained - self._explained)
        self._explained = explained
        if missing <= 0:
            return
        if overrun:
            self._samples.dropped += missing
            self._explained += missing
        else:
            self._statistics.lost += missing

    def _complain(self, text: str) -> None:
        now = time.monotonic()
        if now - self._complained >= 1.0:
            self._complained = now
            logger.warning("%s: message %s", self.name, text)
