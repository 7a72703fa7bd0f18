"""The owner's side of rewiring: its inputs read what third parties ask for."""

from typing import TYPE_CHECKING, Any

from bus.errors import BusError
from bus.input import Input
from bus.names import did_you_mean

if TYPE_CHECKING:
    from bus.node import Node


class Connector:
    """The verbs ``connect`` and ``disconnect`` of a service."""

    def __init__(self, node: "Node"):
        self._node = node
        node.verb("connect", self._connect, "read a port from now on")
        node.verb("disconnect", self._disconnect, "read a port no more")

    def _connect(self, sink: str, source: str) -> dict[str, Any]:
        port = self._input(sink)
        writer = self._node.directory.owner(source)
        if writer is not None and writer.type != port.type_name:
            raise BusError(differs(source, writer.type, sink, port.type_name))
        port.connect(source)
        return self._changed(port)

    def _disconnect(self, sink: str, source: str) -> dict[str, Any]:
        port = self._input(sink)
        port.disconnect(source)
        return self._changed(port)

    def _input(self, sink: str) -> Input:
        port = self._node.ports.get(sink)
        if isinstance(port, Input):
            return port
        inputs = [each.name for each in self._node.ports if isinstance(each, Input)]
        raise LookupError(f"no input {sink} here{did_you_mean(sink, inputs)}")

    def _changed(self, port: Input) -> dict[str, Any]:
        self._node.ports.renew(port)
        return {"sink": port.name, "sources": list(port.sources)}


def differs(source: str, carried: str, sink: str, wanted: str) -> str:
    """Return why an output and an input do not fit."""
    return f"{source} carries {carried}, {sink} reads {wanted}"
