"""Input ports."""

import logging
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import zenoh
from zenoh.handlers import RingChannel

from bus.counters import InputStatistics, Meter
from bus.decoder import Decoder
from bus.directory import Directory
from bus.envelope import Received, new_source
from bus.errors import WireError
from bus.freshness import Freshness
from bus.names import key_of
from bus.output import MAX_MESSAGE
from bus.sample_queue import SampleQueue
from bus.schema import fields_of, type_name
from bus.sequence import Sequences
from bus.waiter import Waiter

logger = logging.getLogger(__name__)

_RING = 64  # messages kept by Zenoh until the pump runs


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
        self.statistics = InputStatistics()
        self._decoder = Decoder(message_type, model, dimensions)
        self._directory = directory
        self._freshness = freshness
        self._sequences = Sequences()
        self._samples = SampleQueue(depth)
        self._max_message = max_message
        self._complained = 0.0
        self._meter = Meter()
        self._pumps = [
            _Pump(session, source, source, self._samples, waiter) for source in self.sources
        ]
        self._pumps.append(_Pump(session, name, None, self._samples, waiter))

    def read(self) -> Received | None:
        """Return the next message, or None when there is none; bad ones are skipped."""
        while (item := self._samples.pop()) is not None:
            received = self._accept(*item)
            if received is not None:
                self.latest = received
                self.statistics.received += 1
                self._freshness.arrived(received)
                return received
        return None

    def newest(self) -> Received | None:
        """Return the newest of all waiting messages, or None when nothing new came."""
        newest = None
        while (received := self.read()) is not None:
            newest = received
        return newest

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

    def info(self) -> dict[str, Any]:
        """Return what `bus.introspection.port_info` shows."""
        self._count_drops()
        return {
            "fields": [field.describe() for field in fields_of(self.type)],
            "description": self.type.__doc__ or "",
            "statistics": self.statistics.as_map(),
            "hz": self._meter.rate(self.statistics.received),
            "fresh": self.fresh,
            "reason": self.reason,
        }

    @property
    def type_name(self) -> str:
        """Name and version of the message type."""
        return type_name(self.type)

    def close(self) -> None:
        """Receive no more; the pumps end."""
        for pump in self._pumps:
            pump.close()

    def _accept(self, sample: zenoh.Sample, arrival: int, origin: str | None) -> Received | None:
        statistics = self.statistics
        try:
            payload = sample.payload
            if len(payload) > self._max_message:
                raise WireError(f"{len(payload)} bytes, limit {self._max_message}")
            data, envelope = self._decoder.decode(payload.to_bytes())
        except WireError as error:
            statistics.refused += 1
            self._complain(f"refused: {error}")
            return None
        if origin is not None and self._directory.leader(origin) != envelope.source:
            statistics.foreign += 1
            self._complain(f"ignored: its writer does not own {origin}")
            return None
        gap = self._sequences.gap(envelope.source, envelope.seq)
        if gap < 0:
            statistics.repeated += 1
            return None
        if gap:
            self._count_drops()
        return Received(data, envelope, arrival)

    def _count_drops(self) -> None:
        """Split the gaps so far into drops of this queue and losses on the wire."""
        statistics = self.statistics
        statistics.dropped = self._samples.dropped
        # drops may run ahead of the gaps read so far, so only the highest difference is certain
        statistics.lost = max(statistics.lost, self._sequences.missing - statistics.dropped)

    def _complain(self, text: str) -> None:
        now = time.monotonic()
        if now - self._complained >= 1.0:
            self._complained = now
            logger.warning("%s: message %s", self.name, text)


class _Pump:
    """Moves the samples of one key into an input's queue and wakes the main thread.

    It ends when its subscriber is undeclared: `recv` has no timeout of its own.
    """

    def __init__(
        self,
        session: zenoh.Session,
        name: str,
        origin: str | None,
        samples: SampleQueue,
        waiter: Waiter,
    ):
        self._subscriber = session.declare_subscriber(key_of(name), RingChannel(_RING))
        arguments = (self._subscriber.handler.recv, origin, samples.push, waiter.wake)
        self._thread = threading.Thread(target=self._run, args=arguments, name=f"pump {name}")
        self._thread.start()

    def _run(self, receive: Callable, origin: str | None, push: Callable, wake: Callable) -> None:
        clock = time.monotonic_ns
        try:
            while True:
                push((receive(), clock(), origin))
                wake()
        except zenoh.ZError:
            wake()

    def close(self) -> None:
        self._subscriber.undeclare()
        self._thread.join()
