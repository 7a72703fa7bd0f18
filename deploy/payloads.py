"""What a port puts on the wire, counted without decoding it."""

import time

import zenoh
from zenoh.handlers import Callback

from bus import Node
from bus.names import key_of


def payload_sizes(node: Node, port: str, seconds: float) -> list[int]:
    """Return the sizes [bytes] of the messages that come within ``seconds`` [s] or until Ctrl-C."""
    sizes: list[int] = []

    def count(sample: zenoh.Sample) -> None:
        sizes.append(len(sample.payload))

    callback = Callback(count, indirect=False)
    subscriber = node.session.declare_subscriber(key_of(port), callback)
    end = time.monotonic() + seconds
    while node.running and (remaining := end - time.monotonic()) > 0:
        node.wait(min(remaining, 0.1))
    subscriber.undeclare()
    return sizes
