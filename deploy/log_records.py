"""Log records of services: the last ones that each keeps, and new ones as they come."""

from collections.abc import Iterator
from typing import Any

from bus import BusError, Input, Node
from deploy.discovery import all_ports, require_port
from deploy.errors import CommandError
from deploy.output import reader_gone
from deploy.streams import open_port

PORT, RPC = "/log:o", "/rpc:i"
LEVELS = ("debug", "info", "warning", "error", "critical")
Record = dict[str, Any]  # time_ns, service, level, logger, text


def services_that_log(node: Node) -> list[str]:
    """Return the services that have a log port."""
    names = [port["name"] for port in all_ports(node)]
    return [name[1:].removesuffix(PORT) for name in names if name.endswith(PORT)]


def recent(node: Node, service: str) -> list[Record]:
    """Return the records that a service keeps, oldest first."""
    answer = node.call(f"/{service}{RPC}", "log", {"action": "recent"}, timeout=2.0)
    return [{"service": service, **record} for record in answer]


def severity(level: str) -> int:
    """Return the rank of a level; one that we do not know is shown always."""
    name = level.lower()
    return LEVELS.index(name) if name in LEVELS else len(LEVELS)


class Follower:
    """Reads the log ports of one service or of all, also of those that come later."""

    def __init__(self, node: Node, service: str | None):
        self._node, self._service = node, service
        self._inputs: dict[str, Input] = {}
        if service is not None:
            require_port(node, f"/{service}{PORT}")
        self._open_new()

    def records(self) -> Iterator[Record]:
        """Yield records as they come, until Ctrl-C or nobody reads our output."""
        while self._node.running and not reader_gone():
            self._node.wait(0.1)
            self._open_new()
            yield from sorted(self._read(), key=lambda record: record["time_ns"])

    def _read(self) -> Iterator[Record]:
        for entry in self._inputs.values():
            while (received := entry.read()) is not None:
                names = ("service", "level", "logger", "text")
                fields = {name: getattr(received.data, name, "") for name in names}
                yield {"time_ns": received.envelope.acquired, **fields}

    def _open_new(self) -> None:
        for name in self._node.directory.names():
            wanted = self._service is None or name == f"/{self._service}{PORT}"
            if wanted and name.endswith(PORT) and name not in self._inputs:
                try:
                    number = len(self._inputs)
                    self._inputs[name] = open_port(self._node, name, name=f"log{number}")
                except (BusError, CommandError):
                    continue  # it has just gone
