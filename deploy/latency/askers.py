"""The asking side of the latency test: one round trip at a time."""

import time
from typing import Protocol

import numpy as np
import zenoh
from zenoh.handlers import Callback

from bus import Node
from bus.introspection import wait_for_port
from bus.session import MAX_MESSAGE
from bus.threads import adopt
from bus.waiter import Waiter
from deploy.errors import CommandError
from deploy.latency.echo import raw_publisher
from deploy.latency.messages import PING, PONG, RAW_PING, RAW_PONG, Payload

MEET = 30.0  # [s] for the other process to start, on a loaded machine


class Asker(Protocol):
    """Something that a message can be sent through, there and back."""

    def trip(self, timeout: float) -> float | None:
        """Return how long a message took [s], or None when it did not come back in time."""
        ...


class PortAsker:
    """Through two ports; ``size`` is the payload's [bytes], in steps of 8."""

    def __init__(self, node: Node, size: int):
        ping, pong = f"/{node.name}/{PING}", f"/{node.name}/echo/{PONG}"
        self._node = node
        self._out = node.output(ping, Payload, max_message=MAX_MESSAGE)
        self._in = node.input(f"/{node.name}/pong:i", Payload, pong, max_message=MAX_MESSAGE)
        self._payload = Payload(values=np.zeros(size // 8))
        node.ready()
        wait_for_port(node, pong, MEET)
        deadline = time.monotonic() + MEET
        while not self._out.matched or self.trip(0.1) is None:
            if time.monotonic() > deadline or not node.running:
                raise CommandError("the other process of the test does not answer")
            time.sleep(0.01)

    @property
    def message_size(self) -> int:
        """Bytes of one message, envelope included."""
        statistics = self._out.statistics
        return statistics.bytes // statistics.written

    def trip(self, timeout: float) -> float | None:
        self._in.newest()  # a late one of before
        start = time.perf_counter()
        self._out.write(self._payload)
        deadline = start + timeout
        while self._in.read() is None:
            if time.perf_counter() > deadline or not self._node.running:
                return None
            self._node.wait(0.05)
        return time.perf_counter() - start


class RawAsker:
    """Through Zenoh alone, in the same two sessions, with messages of ``size`` [bytes]."""

    def __init__(self, session: zenoh.Session, name: str, size: int):
        self._waiter = Waiter()
        self._payload = bytes(size)
        self._publisher = raw_publisher(session, f"{name}/{RAW_PING}")
        self._subscriber = session.declare_subscriber(
            f"{name}/{RAW_PONG}", Callback(self._take, indirect=False)
        )

    def trip(self, timeout: float) -> float | None:
        self._waiter.wait(0.0)  # a late one of before
        start = time.perf_counter()
        self._publisher.put(self._payload)
        while not self._waiter.wait(timeout):
            if time.perf_counter() - start > timeout:
                return None
        return time.perf_counter() - start

    def close(self) -> None:
        """Neither send nor receive any more."""
        self._subscriber.undeclare()
        self._publisher.undeclare()

    def _take(self, sample: zenoh.Sample) -> None:
        adopt()
        sample.payload.to_bytes()
        self._waiter.wake()
