"""How an input's messages come to it: pumped by a thread, or polled by the main thread."""

import threading
import time
from collections.abc import Callable

import zenoh
from zenoh.handlers import RingChannel

from bus.directory import Directory
from bus.sample_queue import SampleQueue

RING = 64  # messages kept by Zenoh until a pump runs


class Receiver:
    """Receives the samples of one key for an input's queue.

    Of a sample above the limit only its size goes on, so that the queue's memory is bounded.

    Args:
        key: Where the messages are put.
        origin: The port when only its owner is heard, else None.
        samples: Where the samples go.
        limit: Of one message [bytes].
        ring: Messages that Zenoh keeps until we take them.
    """

    def __init__(
        self,
        session: zenoh.Session,
        directory: Directory,
        key: str,
        origin: str | None,
        samples: SampleQueue,
        limit: int,
        ring: int,
    ):
        self._key, self._origin, self._leader = key, origin, directory.leader
        self._push, self._limit, self._ring = samples.push, limit, ring
        self._session = session
        self._subscriber = self._subscribe()

    def _subscribe(self) -> zenoh.Subscriber:
        return self._session.declare_subscriber(self._key, RingChannel(self._ring))

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

    def rest(self, resting: bool) -> None:
        """Receive nothing for a while; writers then have one reader less. Or go on."""
        if resting and not self._resting and self._origin is not None:
            self._resting = True
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
        arrival, limit, origin = time.monotonic_ns(), self._limit, self._origin
        if origin is not None:
            self._owner = self._leader(origin) or self._owner
        overrun = len(samples) == self._ring
        for sample in samples:
            size = len(sample.payload)
            part = sample if size <= limit else size
            self._push((part, arrival, origin, self._owner, overrun))
            overrun = False


class Pump(Receiver):
    """Moves samples by a thread of its own, as they come, and wakes the main thread.

    The pump ends when its subscriber is undeclared: `recv` has no timeout of its own.
    """

    def start(self, wake: Callable[[], None]) -> None:
        """Begin; ``wake`` is called for every sample."""
        self._wake = wake
        self._thread = threading.Thread(target=self._run, name=f"pump {self._key}")
        self._thread.start()

    def close(self) -> None:
        super().close()
        self._thread.join()

    def _run(self) -> None:
        receive, push, wake = self._subscriber.handler.recv, self._push, self._wake
        clock, limit, leader, origin = time.monotonic_ns, self._limit, self._leader, self._origin
        owner = None
        try:
            while True:
                sample = receive()
                size = len(sample.payload)
                if origin is not None:
                    owner = leader(origin) or owner  # the last one may have left after writing
                push((sample if size <= limit else size, clock(), origin, owner, False))
                wake()
        except zenoh.ZError:
            wake()
