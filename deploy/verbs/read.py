"""``wrenchbus read``, ``echo``, ``sample``: the messages of a port."""

from typing import TYPE_CHECKING, Annotated

import typer

from deploy.errors import CommandError
from deploy.options import Json, Port, Seconds, on_the_bus
from deploy.output import print_json, print_line, print_warning, reader_gone

if TYPE_CHECKING:
    from bus import Node, Received

Envelope = Annotated[
    bool, typer.Option("--envelope", help="Show sequence number, stamp, age and validity.")
]


@on_the_bus
def read(
    node: "Node",
    port: Port,
    count: Annotated[int | None, typer.Option("-n", "--count", min=1, help="Stop after N.")] = None,
    seconds: Seconds = None,
    envelope: Envelope = False,
    as_json: Json = False,
) -> None:
    """Print the messages of a port; Ctrl-C ends it.

    With --json one object per line, always with its envelope. What was missed is told at the
    end, on standard error.
    """
    from deploy.streams import messages, missed, open_port

    entry = open_port(node, port)
    for number, received in enumerate(messages(node, entry, seconds), start=1):
        if number > 1 and not as_json:
            print_line("---")
        _show(port, received, envelope, as_json)
        if number == count:
            break
    if (told := missed(entry)) and not reader_gone():
        print_warning(f"messages of {port} missed: {told}")


@on_the_bus
def sample(
    node: "Node",
    port: Port,
    timeout: Annotated[float, typer.Option(min=0.0, help="Seconds to wait for it.")] = 5.0,
    envelope: Envelope = False,
    as_json: Json = False,
) -> None:
    """Print the next message of a port and end.

    Exit status 1 when none comes in time.
    """
    from deploy.streams import messages, open_port

    entry = open_port(node, port, depth=1)
    received = next(messages(node, entry, timeout), None)
    if received is not None:
        _show(port, received, envelope, as_json)
    elif not node.running:
        raise KeyboardInterrupt
    elif not reader_gone():
        raise CommandError(f"no message on {port} within {timeout:g} s")


def _show(port: str, received: "Received", envelope: bool, as_json: bool) -> None:
    from deploy.show import message_text
    from deploy.streams import as_map

    if as_json:
        print_json(as_map(port, received))
    else:
        print_line(message_text(received, envelope))
