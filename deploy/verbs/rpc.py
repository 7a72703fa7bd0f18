"""``wrenchbus rpc``: any verb of any service."""

from typing import TYPE_CHECKING, Annotated, Any

import typer
import yaml

from deploy.errors import UsageError
from deploy.options import Json, on_the_bus
from deploy.output import print_answer, print_json

if TYPE_CHECKING:
    from bus import Node


def arguments(pairs: list[str]) -> dict[str, Any]:
    """Read ``key=value`` pairs; values are YAML: ``3``, ``true``, ``[0, 0, 1]``, ``text``."""
    values = {}
    for pair in pairs:
        key, equals, text = pair.partition("=")
        if not equals or not key:
            raise UsageError(f"expected KEY=VALUE such as seconds=1.0, got {pair!r}")
        try:
            values[key] = yaml.safe_load(text)
        except yaml.YAMLError:
            raise UsageError(f"the value of {key} is not YAML: {text!r}") from None
    return values


@on_the_bus
def rpc(
    node: "Node",
    port: Annotated[str, typer.Argument(help="RPC port, as /torque_observer/rpc:i.")],
    verb: Annotated[str, typer.Argument(help="What to ask; `help` lists the verbs.")] = "help",
    pairs: Annotated[
        list[str] | None, typer.Argument(metavar="[KEY=VALUE]...", help="Arguments.")
    ] = None,
    timeout: Annotated[float, typer.Option(min=0.01, help="Seconds to wait.")] = 5.0,
    as_json: Json = False,
) -> None:
    """Send a request to a service and print the answer."""
    from deploy.discovery import require_port

    require_port(node, port)
    answer = node.call(port, verb, arguments(pairs or []), timeout=timeout)
    if as_json:
        print_json(answer)
    else:
        print_answer(answer)
