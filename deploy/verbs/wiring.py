"""``wrenchbus connect``, ``disconnect``, ``connections``: who reads whom, changed at run time."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.completion import complete_port
from deploy.errors import UsageError
from deploy.options import Json, at_most_one, on_the_bus
from deploy.output import print_json, print_line, print_table

if TYPE_CHECKING:
    from bus import Node

Source = Annotated[
    str, typer.Argument(help="Output, as /icub/torques:o.", autocompletion=complete_port)
]
Sink = Annotated[str, typer.Argument(help="Input, as /logger/in:i.", autocompletion=complete_port)]
Persist = Annotated[
    bool, typer.Option("--persist", help="Also after a restart of either side, or later.")
]


@on_the_bus
def connect(
    node: "Node", source: Source, sink: Sink, persist: Persist = False, as_json: Json = False
) -> None:
    """Let an input read an output from now on.

    Both must stand and be of one type; with --persist either may come later.
    """
    from bus.wiring import connect as connect_ports
    from deploy.discovery import require_port

    _check_names(source, sink)
    if not persist:
        require_port(node, source)
        require_port(node, sink)
    result = connect_ports(node, source, sink, persist=persist)
    if as_json or source in result["sources"]:
        _tell(result, as_json)
    else:
        print_line(f"{sink} will read {source} whenever both stand")


@on_the_bus
def connections(node: "Node", as_json: Json = False) -> None:
    """List who reads whom, and what shall be connected, or apart, for good.

    A connection waits when one of its ports does not stand, or the input is to be opened again.
    """
    from bus.introspection import hear_all
    from bus.wiring import connections as all_connections

    hear_all(node)
    rows = [connection._asdict() for connection in all_connections(node)]
    if as_json:
        print_json(rows)
    else:
        print_table(rows, ["source", "sink", "state", "persistent"])


@on_the_bus
def disconnect(
    node: "Node",
    source: Source,
    sink: Sink,
    persist: Persist = False,
    forget: Annotated[
        bool, typer.Option("--forget", help="Only forget what --persist has said of the two.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Let an input read an output no more.

    With --persist also after a restart, even where its settings say otherwise.
    """
    from bus.wiring import disconnect as disconnect_ports
    from bus.wiring import forget as forget_wish
    from deploy.discovery import require_port

    at_most_one({"--persist": persist, "--forget": forget})
    _check_names(source, sink)
    if forget:
        _tell(forget_wish(node, source, sink), as_json, "forgotten; at present ")
        return
    if not persist:
        require_port(node, sink)
    _tell(disconnect_ports(node, source, sink, persist=persist), as_json)


def _check_names(source: str, sink: str) -> None:
    from bus import BusError
    from bus.names import check_name

    try:
        check_name(source, "output")
        check_name(sink, "input")
    except BusError as error:
        raise UsageError(str(error)) from None


def _tell(result: dict[str, Any], as_json: bool, before: str = "") -> None:
    if as_json:
        print_json(result)
    else:
        sources = ", ".join(result["sources"]) or "nothing"
        print_line(f"{before}{result['sink']} reads {sources}")
