"""The other process of the latency test: ``python -m deploy.latency.echo``.

What comes from the asker goes back, over ports and, beside them, over Zenoh alone.
"""

import argparse
import threading
from contextlib import closing

import zenoh
from zenoh.handlers import FifoChannel

from bus import Node
from bus.session import MAX_MESSAGE
from bus.signals import stop_flag
from deploy.latency.messages import PING, PONG, RAW_PING, RAW_PONG, Payload


def main() -> None:
    """Echo until asked to end."""
    stop_flag.install()
    parser = argparse.ArgumentParser()
    for flag in ("--connect", "--namespace", "--asker"):
        parser.add_argument(flag)
    options = parser.parse_args()
    asker = options.asker
    with Node(f"{asker}/echo", connect=options.connect, namespace=options.namespace) as node:
        name, source = f"/{node.name}/in:i", f"/{asker}/{PING}"
        pings = node.input(name, Payload, source, max_message=MAX_MESSAGE)
        pongs = node.output(f"/{asker}/echo/{PONG}", Payload, max_message=MAX_MESSAGE)
        with closing(RawEcho(node.session, asker)):
            node.ready()
            while node.running:
                node.wait(0.1)
                while (received := pings.read()) is not None:
                    pongs.write(received.data, like=received.envelope)


class RawEcho:
    """Sends back what comes without the bus, from a thread of Python's, as services do."""

    def __init__(self, session: zenoh.Session, asker: str):
        self._publisher = raw_publisher(session, f"{asker}/{RAW_PONG}")
        self._subscriber = session.declare_subscriber(f"{asker}/{RAW_PING}", FifoChannel(16))
        self._thread = threading.Thread(target=self._echo, name="echo")
        self._thread.start()

    def _echo(self) -> None:
        for sample in self._subscriber.handler:  # ends when the subscriber does
            self._publisher.put(sample.payload.to_bytes())

    def close(self) -> None:
        """Send nothing back any more."""
        self._subscriber.undeclare()
        self._thread.join()


def raw_publisher(session: zenoh.Session, key: str) -> zenoh.Publisher:
    """Return a publisher with the settings that ports have."""
    return session.declare_publisher(
        key,
        congestion_control=zenoh.CongestionControl.DROP,
        priority=zenoh.Priority.REAL_TIME,
        express=True,
    )


if __name__ == "__main__":
    main()
