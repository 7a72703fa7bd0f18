"""Opens the bus for one verb."""

import os
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager

from bus import BusError, Node, runtime_directory
from bus.child import command
from deploy.launcher.endpoints import with_free_port
from deploy.options import Connection

HUB_DEADLINE = 3.0  # [s]
START = 30.0  # [s] for a hub of our own, on a busy machine


@contextmanager
def open_bus(
    connection: Connection, deadline: float | None = None, take_over: bool = False
) -> Iterator[Node]:
    """Open a node under a name of its own, see the hub, and close the node with the verb.

    Args:
        deadline: How long to wait for the hub [s]; None is `HUB_DEADLINE`.
        take_over: Take names from those who have them, who then end.

    Raises:
        BusError: No bus was found, or several, or nobody answers at the hub's endpoint.
    """
    with Node(
        f"wrenchbus-{os.getpid()}",
        connect=connection.connect,
        listen=connection.listen,
        zenoh_config=connection.config,
        namespace=connection.namespace,
        insecure=connection.insecure,
        take_over=take_over,
    ) as node:
        _meet_hub(node, HUB_DEADLINE if deadline is None else deadline)
        yield node


def _meet_hub(node: Node, patience: float) -> None:
    deadline = time.monotonic() + patience
    while not list(node.session.info.routers_zid()):
        if not node.running:
            raise KeyboardInterrupt
        if time.monotonic() > deadline:
            raise BusError(f"no hub answers at {node.endpoint}")
        time.sleep(0.005)


@contextmanager
def any_bus(connection: Connection) -> Iterator[Node]:
    """Open the bus as `open_bus` does; where none runs, one of our own for the time being."""
    if is_told(connection):
        with open_bus(connection) as node:
            yield node
        return
    with _own_hub() as endpoint:
        with open_bus(connection._replace(connect=endpoint), START) as node:
            yield node


def is_told(connection: Connection) -> bool:
    """Whether anything says where a bus is: a flag, the environment, the runtime directory."""
    told = connection.connect or os.environ.get("WRENCHBUS_CONNECT")
    return bool(told or runtime_directory.entries())


@contextmanager
def _own_hub() -> Iterator[str]:
    endpoint = with_free_port("tcp/127.0.0.1:0")
    arguments = ["--no-announce", "--settle", "0", "--listen", endpoint]
    process = subprocess.Popen(command("bus.hub", *arguments), start_new_session=True)
    try:
        yield endpoint
    finally:
        process.terminate()
        process.wait()
