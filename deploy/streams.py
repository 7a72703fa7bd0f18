"""Reads any port, whatever its type."""

import time
from collections.abc import Iterator
from typing import Any

from bus import Input, Node, Received
from bus.described_type import build
from bus.session import MAX_MESSAGE
from deploy.description import describe_output
from deploy.output import reader_gone

DEPTH = 4096  # messages; a slow terminal must not look like a loss
MEMORY = 256 << 20  # bytes that a full queue may hold


def open_port(node: Node, port: str, depth: int = DEPTH, name: str = "read") -> Input:
    """Open an input that reads a port, with the type and the limit that the port tells.

    Args:
        name: Of the input, below the node's.

    Raises:
        UsageError: There is no such port, or it is not an output.
    """
    info = describe_output(node, port)
    limit = info.get("max_message", MAX_MESSAGE)
    return node.input(
        f"/{node.name}/{name}:i",
        build(info["type"], info["fields"]),
        source=port,
        depth=max(1, min(depth, MEMORY // limit)),
        max_message=limit,
    )


def messages(node: Node, entry: Input, seconds: float | None) -> Iterator[Received]:
    """Yield what arrives until ``seconds`` [s] have passed, Ctrl-C, or nobody reads our output."""
    end = float("inf") if seconds is None else time.monotonic() + seconds
    while node.running and (remaining := end - time.monotonic()) > 0:
        if not node.wait(min(remaining, 0.1)) and reader_gone():
            return
        while node.running and (received := entry.read()) is not None:
            yield received


def missed(entry: Input) -> str:
    """Return in words what an input did not get, or could not keep or read; empty when nothing."""
    counted = entry.statistics
    kinds = {
        "lost on the wire": counted.lost,
        "dropped, as they came faster than they were taken": counted.dropped,
        "too late to be read": counted.late,
        "refused": counted.refused + counted.foreign,
    }
    return ", ".join(f"{count} {kind}" for kind, count in kinds.items() if count)


def as_map(port: str, received: Received) -> dict[str, Any]:
    """Return a message as ``{port, envelope, data}``."""
    data = {name: getattr(received.data, name) for name in received.data.__dataclass_fields__}
    return {"port": port, "envelope": received.envelope._asdict(), "data": data}
