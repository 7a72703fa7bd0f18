"""How an input's messages come to it: delivered by Zenoh's thread, or polled by the main one."""

import time
from collections.abc import Callable
from typing import Any

import zenoh
from zenoh.handlers import Callback, RingChannel

from bus.directory import Directory
from bus.packing import unpack
from bus.sample_queue import SampleQueue
from bus.sequence import Sequences
from bus.stream import BUNDLE
from bus.threads import adopt


class Receiver:
    """Receives the samples of one key for an input's queue: one connection, as long as it lasts.

    Of a message above the limit only its size goes on, so that the queue's memory is bounded.
    Sequence numbers count within a connection: what passes before it, or between two, is not lost.

    Args:
        key: Where the messages are put.
        origin: The port when only its owner is heard, else None.
        samples: Where the samples go.
        limit: Of one message [bytes].
        handler: Zenoh's, which gets them first.
    """

    def __init__(
        self,
        session: zenoh.Session,
        directory: Directory,
        key: str,
        origin: str | None,
        samples: SampleQueue,
        limit: int,
        handler: Any,
    ):
        self.origin, self.sequences = origin, Sequences()
        self._key, self._leader = key, directory.leader
        self._push, self._limit = samples.push, limit
        self._session, self._handler = session, handler
        self._subscriber = self._subscribe()

    def _subscribe(self) -> zenoh.Subscriber:
        return self._session.declare_subscriber(self._key, self._handler)

    def rest(self, resting: bool) -> None:
        """Receive nothing for a while, or go on; only who polls can rest."""

    def collect(self) -> None:
        """Move what has come into the queue, where that is not done as it comes."""

    def close(self) -> None:
        """Receive no more."""
        self._subscriber.undeclare()


class Poll(Receiver):
    """Takes samples only when the main thread looks: neither a thread nor a wake per sample.

    They arrive, as far as we know, when we look. What a full ring has lost to newer ones
    is dropped by this queue, not lost on the wire.
    """

    _owner: bytes | None = None  # the last one; it may have left after writing
    _resting = False

    def __init__(self, *arguments: Any, ring: int, bundled: bool = False):
        self._ring = ring  # messages, or bundles of them, that Zenoh keeps until we look
        self._bundled = bundled
        super().__init__(*arguments, handler=RingChannel(ring))

    def rest(self, resting: bool) -> None:
        """Receive nothing for a while; writers then have one reader less. Or go on."""
        if resting and not self._resting and self.origin is not None:
            self._resting, self.sequences = True, Sequences()
            self._subscriber.undeclare()
        elif self._resting and not resting:
            self._resting = False
            self._subscriber = self._subscribe()

    def close(self) -> None:
        if not self._resting:
            super().close()

    def collect(self) -> None:
        """Move what has come into the queue."""
        if self._resting:
            return
        receive = self._subscriber.handler.try_recv
        samples = []
        while len(samples) < self._ring and (sample := receive()) is not None:
            samples.append(sample)
        if not samples:
            return
        arrival, limit, origin = time.monotonic_ns(), self._limit, self.origin
        if origin is not None:
            self._owner = self._leader(origin) or self._owner
        overrun = len(samples) == self._ring
        for sample in samples:
            for part in self._split(sample.payload):
                if type(part) is bytes and len(part) > limit:
                    part = len(part)
                self._push((part, arrival, self, self._owner, overrun))
                overrun = False

    def _split(self, payload: zenoh.ZBytes) -> list[bytes] | list[int]:
        """Return the messages of a payload, or its size when it is too large.

        What is no bundle is refused later, as a message.
        """
        if len(payload) > self._limit + (BUNDLE if self._bundled else 0):
            return [len(payload)]
        whole = payload.to_bytes()
        if not self._bundled:
            return [whole]
        try:
            parts = unpack(whole)
        except ValueError:
            return [whole]
        return parts if _is_bundle(parts) else [whole]


class Delivery(Receiver):
    """Takes samples in Zenoh's own thread, as they come, and wakes the main thread.

    Nothing is done there but to note the sample, so that the link is not held up.
    """

    _owner: bytes | None = None

    def __init__(self, *arguments: Any, wake: Callable[[], None]):
        self._wake = wake
        super().__init__(*arguments, handler=Callback(self._take, indirect=False))

    def _take(self, sample: zenoh.Sample) -> None:
        adopt()
        origin, payload = self.origin, sample.payload
        size = len(payload)
        if origin is not None:
            self._owner = self._leader(origin) or self._owner  # it may have left after writing
        part = payload.to_bytes() if size <= self._limit else size
        self._push((part, time.monotonic_ns(), self, self._owner, False))
        self._wake()


def _is_bundle(parts: Any) -> bool:
    return type(parts) is list and all(type(part) is bytes for part in parts)
