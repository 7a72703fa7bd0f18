"""``wrenchbus ping``: how long a service takes to answer."""

import time
from typing import TYPE_CHECKING, Annotated

import typer

from deploy.distribution import distribution
from deploy.errors import CommandError
from deploy.options import Json, PortOrService, on_the_bus
from deploy.output import print_json, print_line

if TYPE_CHECKING:
    from bus import Node


@on_the_bus
def ping(
    node: "Node",
    name: PortOrService,
    count: Annotated[int, typer.Option("-n", "--count", min=1, help="How many times.")] = 5,
    interval: Annotated[float, typer.Option(min=0.0, help="Seconds between two.")] = 0.2,
    timeout: Annotated[float, typer.Option(min=0.01, help="Seconds for one answer.")] = 2.0,
    as_json: Json = False,
) -> None:
    """Measure round trips of requests to a service, or to the owner of a port.

    They are answered by its main loop, so a busy one takes longer. Exit status 1
    when any is not answered.
    """
    port = _rpc_port_of(node, name)
    trips: list[float] = []
    asked = 0
    while asked < count and node.running:
        if asked:
            node.wait(interval)
        asked += 1
        trip = _trip(node, port, timeout)
        trips += [] if trip is None else [trip]
        if not as_json:
            print_line(f"{port}: {'no answer' if trip is None else f'{1e3 * trip:.2f} ms'}")
    if as_json:
        result = {"port": port, "asked": asked, "answered": len(trips)}
        print_json(result | {"min": min(trips, default=None)} | distribution(trips))
    if len(trips) < asked:
        raise CommandError(f"{port} answered {len(trips)} of {asked} requests")


def _rpc_port_of(node: "Node", name: str) -> str:
    from deploy.discovery import require_port, rpc_port

    if name.startswith("/"):
        require_port(node, name)
        token = node.directory.owner(name)
        if token is not None and token.direction != "rpc":
            return f"/{token.owner.service}/rpc:i"
    return rpc_port(node, name)


def _trip(node: "Node", port: str, timeout: float) -> float | None:
    """Return how long one request took [s], or None when it was not answered."""
    from bus import RpcAbsent, RpcTimeout

    start = time.monotonic()
    try:
        node.call(port, "help", timeout=timeout)
    except (RpcAbsent, RpcTimeout):
        return None
    return time.monotonic() - start
