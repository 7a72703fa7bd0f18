"""Flags that verbs share, and the open bus that most of them work on."""

from collections.abc import Callable
from functools import wraps
from inspect import Parameter, signature
from typing import Annotated, Any

import typer

Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")]
Robot = Annotated[str | None, typer.Option("--robot", help="Robot name; default: the one alive.")]
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
CONNECTION = {
    "connect": Connect,
    "listen": Listen,
    "config": ZenohConfig,
    "namespace": Namespace,
}


def on_the_bus(verb: Callable[..., None]) -> Callable[..., None]:
    """Give a verb the connection flags; it is called with an open node as first argument."""

    @wraps(verb)
    def command(connect: str, listen: str, config: str, namespace: str, **arguments: Any) -> None:
        from deploy.session import open_bus  # the wire is not loaded for --help

        with open_bus(connect, listen, config, namespace) as node:
            verb(node, **arguments)

    own = list(signature(verb).parameters.values())[1:]
    flags = [
        Parameter(name, Parameter.KEYWORD_ONLY, default=None, annotation=annotation)
        for name, annotation in CONNECTION.items()
    ]
    shown = [parameter.replace(kind=Parameter.KEYWORD_ONLY) for parameter in own] + flags
    command.__signature__ = signature(verb).replace(parameters=shown)  # type: ignore[attr-defined]
    command.__annotations__ = {parameter.name: parameter.annotation for parameter in shown}
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
    return x, y, z
