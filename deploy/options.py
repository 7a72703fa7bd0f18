"""Flags that verbs share, and the open bus that most of them work on."""

from collections.abc import Callable
from functools import wraps
from inspect import Parameter, signature
from math import isfinite
from typing import Annotated, Any, NamedTuple

import typer

from deploy.completion import complete_either, complete_port, complete_service

Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")]
Robot = Annotated[str | None, typer.Option("--robot", help="Robot name; default: the one alive.")]
Description = Annotated[str, typer.Option("--robot", help="Robot name, or its description file.")]
Port = Annotated[
    str, typer.Argument(help="Port, as /icub/torques:o.", autocompletion=complete_port)
]
Service = Annotated[
    str, typer.Argument(help="Service, as torque_observer.", autocompletion=complete_service)
]
PortOrService = Annotated[
    str,
    typer.Argument(
        metavar="PORT_OR_SERVICE",
        help="Port, as /icub/torques:o, or service, as torque_observer.",
        autocompletion=complete_either,
    ),
]
Seconds = Annotated[float | None, typer.Option("--seconds", min=0.0, help="Stop after so long.")]

Connect = Annotated[
    str | None,
    typer.Option("-e", "--connect", metavar="ENDPOINT", help="Hub to join; default: found."),
]
Listen = Annotated[
    str | None, typer.Option("-l", "--listen", metavar="ENDPOINT", help="Where to accept peers.")
]
ZenohConfig = Annotated[
    str | None, typer.Option("-c", "--config", metavar="FILE", help="Zenoh configuration file.")
]
Namespace = Annotated[
    str | None, typer.Option("--namespace", help="Key prefix of the session; default: found.")
]
Insecure = Annotated[
    bool, typer.Option("--insecure", help="Allow other machines, without any protection.")
]


class Connection(NamedTuple):
    """How to join the bus: what the flags of that name said."""

    connect: str | None = None
    listen: str | None = None
    config: str | None = None
    namespace: str | None = None
    insecure: bool = False


FLAGS = dict(
    zip(Connection._fields, (Connect, Listen, ZenohConfig, Namespace, Insecure), strict=True)
)


def with_connection(verb: Callable[..., None]) -> Callable[..., None]:
    """Give a verb the connection flags; it is called with a `Connection` as first argument."""

    @wraps(verb)
    def command(**arguments: Any) -> None:
        connection = Connection(**{name: arguments.pop(name) for name in FLAGS})
        verb(connection, **arguments)

    own = list(signature(verb).parameters.values())[1:]
    defaults = Connection()
    flags = [
        Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=FLAGS[name])
        for name, default in defaults._asdict().items()
    ]
    shown = [parameter.replace(kind=Parameter.KEYWORD_ONLY) for parameter in own] + flags
    command.__signature__ = signature(verb).replace(parameters=shown)  # type: ignore[attr-defined]
    command.__annotations__ = {parameter.name: parameter.annotation for parameter in shown}
    return command


def on_the_bus(verb: Callable[..., None]) -> Callable[..., None]:
    """Give a verb the connection flags; it is called with an open node as first argument.

    The node takes names over when the verb has an option ``take_over`` that is set.
    """

    @with_connection
    @wraps(verb)
    def command(connection: Connection, **arguments: Any) -> None:
        from bus import BusError  # the wire is not loaded for --help
        from deploy.errors import UsageError
        from deploy.session import open_bus

        with open_bus(connection, take_over=arguments.get("take_over", False)) as node:
            try:
                verb(node, **arguments)
            except (BusError, UsageError):
                if node.running:
                    raise
                raise KeyboardInterrupt from None  # what was cut short is no news

    return command


def checked_vector(text: str) -> str:
    """Refuse a text that is not ``X,Y,Z`` while the command line is read."""
    vector(text)
    return text


def vector(text: str) -> tuple[float, float, float]:
    """Read ``X,Y,Z``."""
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise typer.BadParameter(f"expected X,Y,Z such as 0,0,-15, got {text!r}") from None
    if not all(map(isfinite, (x, y, z))):
        raise typer.BadParameter(f"expected finite numbers, got {text!r}")
    return x, y, z


def at_most_one(wishes: dict[str, object]) -> None:
    """Refuse options that exclude each other; ``wishes`` are their values by name."""
    *names, last = wishes
    if sum(map(bool, wishes.values())) > 1:
        raise typer.BadParameter(f"expected one of {', '.join(names)} and {last}")
