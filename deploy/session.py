"""Opens the bus for one verb."""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager

from bus import Node
from deploy.errors import CommandError

HUB_DEADLINE = 3.0  # [s]


@contextmanager
def open_bus(
    connect: str | None, listen: str | None, config: str | None, namespace: str | None
) -> Iterator[Node]:
    """Open a node under a name of its own, see the hub, and close the node with the verb.

    Raises:
        CommandError: Nobody answers at the hub's endpoint.
        BusError: No bus was found, or several.
    """
    with Node(
        f"wrenchbus-{os.getpid()}",
        connect=connect,
        listen=listen,
        zenoh_config=config,
        namespace=namespace,
    ) as node:
        _meet_hub(node)
        yield node


def _meet_hub(node: Node) -> None:
    deadline = time.monotonic() + HUB_DEADLINE
    while not list(node.session.info.routers_zid()):
        if time.monotonic() > deadline or not node.running:
            raise CommandError(f"no hub answers at {node.endpoint}")
        time.sleep(0.005)
