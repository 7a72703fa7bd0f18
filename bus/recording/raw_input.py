"""A port's messages as bytes, none skipped, at the least cost for its writer."""

from collections.abc import Iterator
from typing import Any

from bus.directory import Directory
from bus.envelope import Envelope, envelope_of
from bus.errors import WireError
from bus.names import key_of, stream_key
from bus.receivers import Poll
from bus.sample_queue import SampleQueue
from bus.session import MAX_MESSAGE
from bus.tokens import Token

RING = 1024  # bundles of 4 ms, or messages to an input, that wait for us
DEPTH = 65536  # messages


class RawInput:
    """Reads an output's bundled stream, or what is written to an input directly.

    Args:
        session: Of a node.
        directory: The same node's.
        port: The output or input.
    """

    def __init__(self, session: Any, directory: Directory, port: Token):
        self.refused = 0
        self._owned = port.direction == "output"
        self._samples = SampleQueue(DEPTH)
        key = stream_key(port.name, "bundled") if self._owned else key_of(port.name)
        self._poll = Poll(
            *(session, directory, key, port.name if self._owned else None),
            *(self._samples, MAX_MESSAGE),
            ring=RING,
            bundled=self._owned,
        )

    def read(self) -> Iterator[tuple[bytes, Envelope]]:
        """Yield what has come since the last time, of the owner of the name only."""
        self._poll.collect()
        while (item := self._samples.pop()) is not None:
            data, _, _, leader, _ = item
            try:
                envelope = envelope_of(data)
            except WireError:
                self.refused += 1
                continue
            if self._owned and envelope.source != leader:
                continue  # a writer that does not own the name
            yield data, envelope

    def close(self) -> None:
        """Receive no more."""
        self._poll.close()
