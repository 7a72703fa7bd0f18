"""Names from the running bus, for the shell's completion: quick, and silent whatever happens."""

import os
from collections.abc import Callable

import typer


def complete_port(context: typer.Context, incomplete: str) -> list[str]:
    """Return the standing ports that begin as asked."""
    return _complete(context, incomplete, lambda node: node.directory.names())


def complete_service(context: typer.Context, incomplete: str) -> list[str]:
    """Return the ready services that begin as asked."""
    return _complete(context, incomplete, _services)


def complete_either(context: typer.Context, incomplete: str) -> list[str]:
    """Return the ports, or without a leading slash the services, that begin as asked."""
    complete = complete_port if incomplete.startswith("/") else complete_service
    return complete(context, incomplete)


def _complete(context: typer.Context, incomplete: str, names: Callable) -> list[str]:
    try:
        from bus.introspection import hear_all
        from deploy.options import Connection
        from deploy.session import open_bus

        given = {name: value for name, value in context.params.items() if value is not None}
        connection = Connection(
            **{name: given[name] for name in Connection._fields if name in given}
        )
        with open_bus(connection, deadline=0.5) as node:
            hear_all(node, timeout=0.5)
            found = sorted({name for name in names(node) if name.startswith(incomplete)})
    except Exception:  # no bus, or a broken one: nothing to suggest, and no word in the prompt
        return []
    return [name[_already_there(incomplete) :] for name in found]


def _services(node) -> list[str]:
    return [owner.service for owner in node.directory.services()]


def _already_there(incomplete: str) -> int:
    """Return how much of the word bash does not replace: it begins a new one at each colon."""
    bash = os.environ.get("_WRENCHBUS_COMPLETE") == "complete_bash"
    return incomplete.rfind(":") + 1 if bash else 0
