"""``wrenchbus exists``, ``wait``, ``where``: who is there."""

import time
from datetime import datetime
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.completion import complete_port
from deploy.errors import CommandError
from deploy.options import Connection, Json, Port, PortOrService, on_the_bus, with_connection
from deploy.output import print_json, print_table

if TYPE_CHECKING:
    from bus import Node

Sink = Annotated[
    str | None,
    typer.Argument(
        metavar="[INPUT]", help="Input that reads the port.", autocompletion=complete_port
    ),
]
RETRY = 0.2  # [s]


@on_the_bus
def exists(node: "Node", name: PortOrService, sink: Sink = None) -> None:
    """Tell by the exit status whether a port or service is there: 0 yes, 1 no.

    With INPUT: whether that input reads the port.
    """
    from bus.introspection import hear_all

    def found() -> bool:
        return _found(node, name, sink)

    hear_all(node, found)
    if found():
        return
    if not node.running:
        raise KeyboardInterrupt  # not all were heard
    raise typer.Exit(1)


@with_connection
def wait(
    connection: Connection,
    name: PortOrService,
    sink: Sink = None,
    timeout: Annotated[
        float | None, typer.Option(min=0.0, help="Seconds; default: for ever.")
    ] = None,
) -> None:
    """Wait until a port or service is there: exit status 0, or 1 after --timeout.

    With INPUT: until that input reads the port. The bus itself may start later.
    """
    from bus import BusError
    from deploy.session import open_bus

    deadline = time.monotonic() + (float("inf") if timeout is None else timeout)
    what = f"{name} -> {sink}" if sink else name
    trouble = f"{what} is not there after {timeout:g} s" if timeout is not None else ""
    while True:
        try:
            with open_bus(connection) as node:
                _wait(node, name, sink, deadline, trouble)
                return
        except BusError as error:  # no bus yet, or it has gone
            if time.monotonic() + RETRY > deadline:
                raise CommandError(f"{trouble}: {error}") from None
        time.sleep(RETRY)


@on_the_bus
def where(node: "Node", port: Port, as_json: Json = False) -> None:
    """Tell who owns a port: service, host, process, and since when."""
    from bus.introspection import list_ports
    from deploy.discovery import require_port

    require_port(node, port)
    [entry] = [entry for entry in list_ports(node, settle=0.0) if entry["name"] == port]
    row: dict[str, Any] = {"port": port, **entry["owner"], "epoch": entry["epoch"]}
    row["since"] = (
        datetime.fromtimestamp(1e-9 * entry["since"]).astimezone().isoformat(" ", "milliseconds")
    )
    if as_json:
        print_json(row | {"since_ns": entry["since"]})
    else:
        print_table([row], list(row))


def _wait(node: "Node", name: str, sink: str | None, deadline: float, trouble: str) -> None:
    while not _found(node, name, sink):
        if time.monotonic() > deadline:
            raise CommandError(trouble)
        if not node.running:
            raise KeyboardInterrupt
        time.sleep(0.005)


def _found(node: "Node", name: str, sink: str | None) -> bool:
    from deploy.discovery import are_connected, is_there

    return is_there(node, name) if sink is None else are_connected(node, name, sink)
