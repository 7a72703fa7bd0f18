"""The other process of the latency test: ``python -m deploy.latency.echo``.

What comes from the asker goes back, over ports and, beside them, over Zenoh alone.
"""

import argparse

import zenoh
from zenoh.handlers import Callback

from bus import Node
from bus.session import MAX_MESSAGE
from bus.signals import stop_flag
from bus.threads import adopt
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
        raw = echo_raw(node.session, asker)
        node.ready()
        while node.running:
            node.wait(0.1)
            while (received := pings.read()) is not None:
                pongs.write(received.data, like=received.envelope)
        raw.undeclare()


def echo_raw(session: zenoh.Session, asker: str) -> zenoh.Subscriber:
    """Send back what comes without the bus, in the thread in which it comes."""
    publisher = raw_publisher(session, f"{asker}/{RAW_PONG}")

    def echo(sample: zenoh.Sample) -> None:
        adopt()
        publisher.put(sample.payload)

    return session.declare_subscriber(f"{asker}/{RAW_PING}", Callback(echo, indirect=False))


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
