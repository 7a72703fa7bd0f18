"""Records what the ports of a bus carry, those included that appear later."""

import time
from collections.abc import Collection
from typing import Any

from bus.errors import BusError
from bus.introspection import port_info
from bus.node import Node
from bus.recording.raw_input import RawInput
from bus.recording.writer import RecordingWriter
from bus.tokens import Token

ANSWER = 0.5  # s for a port's owner to describe it


class Recorder:
    """Moves messages from ports into a file; call `step` some 50 times per second.

    Args:
        node: Our place on the bus.
        writer: The file.
        ports: What to record; all outputs and inputs when empty.

    Every method raises OSError when the file cannot be written; the recording is over then.
    """

    def __init__(self, node: Node, writer: RecordingWriter, ports: Collection[str] = ()):
        self.writer = writer
        self._node = node
        self._wanted = frozenset(ports)
        self._inputs: dict[str, RawInput] = {}
        self._channels: dict[tuple[str, str], int] = {}
        self.step()

    @property
    def seconds(self) -> float:
        """How long it has been recording."""
        return (time.time_ns() - self.writer.started) * 1e-9

    def step(self) -> None:
        """Take in what has come."""
        for token in self._node.directory.tokens():
            self._follow(token)
        for name, raw in self._inputs.items():
            self._take(name, raw)
        self.writer.flush()

    def close(self) -> None:
        """Take in the rest, and finish the file."""
        try:
            self.step()
        finally:
            for raw in self._inputs.values():
                raw.close()
            self.writer.close()

    def _follow(self, token: Token) -> None:
        known = (token.name, token.type)
        if known in self._channels or not self._is_wanted(token):
            return
        if token.name not in self._inputs:
            self._inputs[token.name] = RawInput(self._node.session, self._node.directory, token)
        self._channels[known] = self.writer.open_channel(token.name, self._describe(token))

    def _is_wanted(self, token: Token) -> bool:
        if token.direction == "rpc":
            return False
        return not self._wanted or token.name in self._wanted

    def _describe(self, token: Token) -> dict[str, Any]:
        try:
            return port_info(self._node, token.name, ANSWER)
        except BusError:  # gone already
            return {"type": token.type, "direction": token.direction}

    def _take(self, name: str, raw: RawInput) -> None:
        arrival, losses = time.time_ns(), self.writer.losses[name]
        for data, envelope in raw.read():
            channel = self._channels.get((name, envelope.type))
            if channel is None:
                losses.refused += 1
            elif losses.note(envelope):
                self.writer.write(channel, data, envelope, arrival)
        losses.refused += raw.refused
        raw.refused = 0
