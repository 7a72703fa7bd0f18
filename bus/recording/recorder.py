"""Records what the ports of a bus carry, those included that appear later."""

import math
import time
from collections import deque
from collections.abc import Collection
from fnmatch import fnmatchcase
from typing import NamedTuple

from bus.envelope import Envelope
from bus.introspection import port_infos
from bus.names import check_name
from bus.node import Node
from bus.recording.description import Description
from bus.recording.raw_input import RawInput
from bus.recording.writer import RecordingWriter
from bus.stream import THINNED_HZ
from bus.tokens import Token

LAST = 0.5  # s for the owners to tell what they have written, and again until it is here


class _Arrived(NamedTuple):
    data: bytes
    envelope: Envelope
    at: int  # wall [ns]


class Recorder:
    """Moves messages from ports into a file; call `step` some 50 times per second.

    It may be held up for 16 s before a port of 1 kHz loses messages; what is lost is counted.

    Args:
        node: Our place on the bus.
        writer: The file.
        ports: What to record; all outputs and inputs when empty.
        exclude: Patterns of names that are left out of all, as in ``/*/*/state:o``.

    Every method raises OSError when the file cannot be written; the recording is over then.
    """

    def __init__(
        self,
        node: Node,
        writer: RecordingWriter,
        ports: Collection[str] = (),
        exclude: Collection[str] = (),
    ):
        self.writer = writer
        self._node = node
        self._wanted, self._exclude = frozenset(map(check_name, ports)), tuple(exclude)
        self._inputs: dict[str, RawInput] = {}
        self._arrived: dict[str, deque[_Arrived]] = {}
        self._described: dict[str, bytes] = {}  # by port, the opening that was last asked about
        self._asked: dict[str, Description] = {}
        self._channels: dict[tuple[str, str], int] = {}  # by port and type
        self._rates = {token.name: token.rate for token in node.directory.tokens()}
        for name in self._wanted:
            self._listen(name, self._rates.get(name, 0.0))
        self.step()

    @property
    def seconds(self) -> float:
        """How long it has been recording."""
        return (time.time_ns() - self.writer.started) * 1e-9

    @property
    def lost(self) -> int:
        """Messages known to be missing, of all ports."""
        return sum(losses.lost + losses.refused for losses in self.writer.losses.values())

    def step(self) -> None:
        """Take in what has come."""
        for token in self._node.directory.tokens():
            self._follow(token)
        for name in list(self._asked):
            self._describe(name)
        for name, raw in self._inputs.items():
            self._take(name, raw)
        self.writer.flush()

    def close(self) -> None:
        """Take in the rest, and finish the file."""
        try:
            self._take_last()
            self.writer.close()
        finally:
            self.abandon()

    def abandon(self) -> None:
        """Record no more, and leave the file as it is."""
        for raw in self._inputs.values():
            raw.close()
        self._inputs.clear()
        self.writer.abandon()

    def _wants(self, token: Token) -> bool:
        if token.direction == "rpc":
            return False
        if self._wanted:
            return token.name in self._wanted
        return not any(fnmatchcase(token.name, pattern) for pattern in self._exclude)

    def _follow(self, token: Token) -> None:
        """Listen to a new port, and ask whoever has opened it what it carries."""
        if self._described.get(token.name) == token.source or not self._wants(token):
            return
        self._listen(token.name, token.rate)
        self._inputs[token.name].owner = token.source
        self._rates[token.name] = token.rate
        self._described[token.name] = token.source
        self._asked[token.name] = Description(self._node, token)

    def _listen(self, name: str, rate: float) -> None:
        if name not in self._inputs:
            self._inputs[name] = RawInput(self._node.session, self._node.directory, name, rate)
            self._arrived[name] = deque()

    def _describe(self, name: str) -> None:
        """Open a port's channel when its owner has answered; without an answer, when it must be."""
        asked = self._asked[name]
        if (told := asked.told()) is not None:
            self._open(asked.token, told)
            del self._asked[name]
        elif asked.renew() and self._arrived[name]:
            self._open(asked.token, asked.least)

    def _open(self, token: Token, told: dict) -> None:
        self._channels[token.name, token.type] = self.writer.open_channel(token.name, told)

    def _take(self, name: str, raw: RawInput) -> None:
        arrival, arrived = time.time_ns(), self._arrived[name]
        for data, envelope in raw.read():
            arrived.append(_Arrived(data, envelope, arrival))
        while arrived:
            channel = self._channels.get((name, arrived[0].envelope.type))
            if channel is None and name in self._asked:
                return  # its description is on the way
            self._record(channel, arrived.popleft(), raw)
        if (losses := self.writer.losses.get(name)) is not None:
            losses.refused, raw.refused = losses.refused + raw.refused, 0
            losses.foreign, raw.foreign = losses.foreign + raw.foreign, 0

    def _record(self, channel: int | None, message: _Arrived, raw: RawInput) -> None:
        if channel is None:
            raw.refused += 1  # of another type than the port's
        else:
            self.writer.write(channel, message.data, message.envelope, message.at)

    def _take_last(self) -> None:
        """Take in what was written until now; what does not come is lost."""
        told = port_infos(self._node, self._inputs, LAST)
        written = {
            info["name"]: info["statistics"]["written"]
            for info in told
            if "written" in info.get("statistics", ())
        }
        owners = {name: self._node.directory.leader(name) for name in written}
        deadline = time.monotonic() + LAST
        while True:
            self.step()
            behind = {name: self._behind(name, owners[name], written[name]) for name in written}
            if not any(behind.values()) or time.monotonic() > deadline:
                break
            time.sleep(0.01)
        for name, missing in behind.items():
            if missing > self._bundle(name):
                self.writer.losses[name].lost += missing

    def _behind(self, name: str, owner: bytes | None, written: int) -> int:
        losses = self.writer.losses.get(name)
        if losses is None or losses.latest[0] != owner:  # nothing of it was heard
            return 0
        return max(written - losses.latest[1], 0)

    def _bundle(self, name: str) -> int:
        """Messages that may lie in an open bundle, which ends with the next message."""
        return math.ceil(self._rates[name] / THINNED_HZ) if self._inputs[name].bundled else 0
