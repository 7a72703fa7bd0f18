"""Writes ``docs/ports.md`` from the list of ports and the messages.

``python -m robot_model.ports_document > docs/ports.md``
"""

import inspect
from dataclasses import Field, fields
from typing import Any

from robot_model import messages
from robot_model.ports import PORTS, Port

HEAD = """# Ports

Made from `robot_model/ports.py` and `robot_model/messages.py` by
`python -m robot_model.ports_document > docs/ports.md`; a test keeps it current.

`<robot>` is the robot's name (`icub`), `<part>` one of its parts (`left_arm`). Every
message travels in the envelope of [wire.md](wire.md); signs and frames are those of
[conventions.md](conventions.md). A rate of – means now and then. Every service also
answers on `/<service>/rpc:i`, the plant on `/<robot>/sim/rpc:i`, and reads its inputs
on `/<robot>/<service>/<what>:i`.
"""

SHAPES = """# Messages

In shapes, n is the number of joints, k of force/torque sensors, m of inertial
sensors; other letters are free, and equal letters in one message are equal numbers.
Wrenches are [force, moment] in N and N m, twists [linear, angular]. A field marked ?
may be absent. `Clock` belongs to the bus: `time` (ns) and `state` (running, paused).
"""


def ports_document() -> str:
    """Return the document as Markdown."""
    sections = [HEAD, _ports("output", "Outputs"), _ports("input", "Inputs"), SHAPES]
    return "\n".join(sections + [_message(kind) for kind in message_types()])


def message_types() -> list[type]:
    """Return the message types of the robot's processes, in the order of their file."""
    return [kind for kind in vars(messages).values() if "TYPE" in getattr(kind, "__dict__", {})]


def _table(columns: list[str], rows: list[list[str]]) -> str:
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def _ports(direction: str, title: str) -> str:
    listed = [port for port in PORTS.values() if port.direction == direction]
    columns = ["port", "message", "Hz", "service", "what"]
    return f"## {title}\n\n" + _table(columns, [_port(port) for port in listed])


def _port(port: Port) -> list[str]:
    rate = f"{port.rate:g}" if port.rate else "–"
    return [f"`{port.template}`", port.message, rate, port.owner, port.description]


def _message(kind: Any) -> str:
    description = inspect.cleandoc(kind.__doc__)
    columns = ["field", "shape", "unit", "frame"]
    table = _table(columns, [_field(entry) for entry in fields(kind)])
    return f"## {kind.TYPE}\n\n{description}\n\n{table}"


def _field(entry: Field) -> list[str]:
    shape = entry.metadata.get("shape")
    written = ", ".join(map(str, shape)) if shape else _written(entry.type)
    written += " flags" if entry.metadata.get("dtype") == "bool" else ""
    optional = "?" if entry.metadata.get("optional") else ""
    unit, frame = (entry.metadata.get(key, "") for key in ("unit", "frame"))
    return [f"`{entry.name}`{optional}", written, unit, frame]


def _written(annotation: Any) -> str:
    return inspect.formatannotation(annotation).replace("typing.", "")


if __name__ == "__main__":
    print(ports_document(), end="")
