"""``wrenchbus write``: messages from the command line or from standard input."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.completion import complete_port
from deploy.errors import UsageError
from deploy.options import Port, on_the_bus

if TYPE_CHECKING:
    from bus import Node
    from deploy.writer import Writer

MODEL_HELP = "Hash of the joints' names, for inputs that refuse another robot's messages."


@on_the_bus
def write(
    node: "Node",
    port: Port,
    message: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[MESSAGE]", help="'{\"field\": value}' or FIELD=VALUE ...; default: stdin."
        ),
    ] = None,
    type_of: Annotated[
        str | None,
        typer.Option(
            metavar="PORT",
            help="Open a new output PORT of that port's type.",
            autocompletion=complete_port,
        ),
    ] = None,
    rate: Annotated[
        float | None, typer.Option("-r", "--rate", min=0.001, help="Repeat MESSAGE [Hz].")
    ] = None,
    model: Annotated[str | None, typer.Option(metavar="HASH", help=MODEL_HELP)] = None,
    take_over: Annotated[
        bool, typer.Option("--take-over", help="Take an output's name from who has it; that ends.")
    ] = False,
) -> None:
    """Write messages onto an input that stands, or onto a new output (--type-of).

    With --take-over also onto an output that stands, in an epoch above its owner's.

    Each line of standard input is a message: a JSON object of its fields, or
    FIELD=VALUE ... with values in YAML. Exit status 1 when the input refuses any.
    """
    from deploy.message_text import read_fields
    from deploy.writer import Writer

    if rate is not None and not message:
        raise UsageError("--rate repeats a MESSAGE; give one")
    with Writer(node, port, type_of, model, take_over) as writer:
        if not message:
            _write_lines(node, writer)
            return
        for fields in _repeated(node, read_fields(message), rate):
            writer.write(fields)


def _write_lines(node: "Node", writer: "Writer") -> None:
    """Write each line of standard input; the number of a bad one is told."""
    from deploy.lines import input_lines
    from deploy.message_text import read_fields

    for number, line in enumerate(input_lines(lambda: node.running), start=1):
        try:
            writer.write(read_fields([line]))
        except UsageError as error:
            raise UsageError(f"line {number}: {error}") from None


def _repeated(node: "Node", fields: dict[str, Any], rate: float | None) -> Iterator[dict[str, Any]]:
    """Yield a message once, or at a rate [Hz] until Ctrl-C."""
    from bus.periodic import Periodic

    yield fields
    pace = Periodic(1.0 / rate, wait=node.wait) if rate else None
    while pace is not None and node.running:
        pace.next()
        yield fields
