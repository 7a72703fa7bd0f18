"""``wrenchbus rpc``: any verb of any service."""

from typing import TYPE_CHECKING, Annotated

import typer

from deploy.arguments import arguments
from deploy.completion import complete_either
from deploy.options import Json, on_the_bus
from deploy.output import print_answer, print_json

if TYPE_CHECKING:
    from bus import Node


@on_the_bus
def rpc(
    node: "Node",
    port: Annotated[
        str,
        typer.Argument(
            metavar="PORT_OR_SERVICE",
            help="RPC port, as /torque_observer/rpc:i, or its service, as torque_observer.",
            autocompletion=complete_either,
        ),
    ],
    verb: Annotated[str, typer.Argument(help="What to ask; `help` lists the verbs.")] = "help",
    pairs: Annotated[
        list[str] | None, typer.Argument(metavar="[KEY=VALUE]...", help="Arguments.")
    ] = None,
    timeout: Annotated[float, typer.Option(min=0.01, help="Seconds to wait.")] = 5.0,
    as_json: Json = False,
) -> None:
    """Send a request to a service and print the answer."""
    from deploy.discovery import rpc_port

    answer = node.call(rpc_port(node, port), verb, arguments(pairs or []), timeout=timeout)
    if as_json:
        print_json(answer)
    else:
        print_answer(answer)
