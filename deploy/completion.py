"""Names from the running bus, for the shell's completion: quick, and silent whatever happens."""

import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from io import StringIO

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
            return sorted({name for name in names(node) if name.startswith(incomplete)})
    except Exception:  # no bus, or a broken one: nothing to suggest, and no word in the prompt
        return []


@contextmanager
def names_rejoined() -> Iterator[None]:
    """Complete words that bash has split at the colons of port names, which it does not replace."""
    environment = os.environ
    if environment.get("_WRENCHBUS_COMPLETE") != "complete_bash":
        yield
        return
    words = environment["COMP_WORDS"].split("\n")[: int(environment["COMP_CWORD"]) + 1]
    joined = re.sub("\n?:\n?", ":", "\n".join(words))
    environment["COMP_WORDS"], environment["COMP_CWORD"] = joined, str(joined.count("\n"))
    there = joined.rpartition("\n")[2].rfind(":") + 1
    with redirect_stdout(StringIO()) as completed:
        try:
            yield
        finally:
            for line in completed.getvalue().splitlines():
                print(line[there:], file=sys.__stdout__)


def _services(node) -> list[str]:
    return [owner.service for owner in node.directory.services()]
