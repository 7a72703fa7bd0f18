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

RING = 4096  # bundles of 4 ms, or messages, that wait for us in Zenoh: 16 s, 32 MB at 2 MB/s
DEPTH = 65536  # messages, between two reads


class RawInput:
    """Reads an output's stream, or what is written to an input directly.

    Outputs with a rate are read in bundles, which share packets where a link is slow. Of
    events a message could lie in an open bundle until the next one comes, which may be never.

    Args:
        session: Of a node.
        directory: The same node's.
        name: The output or input; it need not stand yet.
        rate: Its nominal rate [Hz], 0 when none or unknown.
    """

    def __init__(self, session: Any, directory: Directory, name: str, rate: float):
        self.refused = self.foreign = 0
        self.owner: bytes | None = None  # the last one that was seen; it may have left since
        self.bundled = name.endswith(":o") and rate > 0.0
        self._owned = name.endswith(":o")
        self._heeded: bytes | None = None
        self._samples = SampleQueue(DEPTH)
        self._poll = Poll(
            *(session, directory, stream_key(name, "bundled") if self.bundled else key_of(name)),
            *(name if self._owned else None, self._samples, MAX_MESSAGE),
            ring=RING,
            bundled=self.bundled,
        )

    def read(self) -> Iterator[tuple[bytes, Envelope]]:
        """Yield what has come since the last time, of the owners of the name only."""
        self._poll.collect()
        while (item := self._samples.pop()) is not None:
            data, _, _, owner, _ = item
            self.owner = owner or self.owner
            try:
                envelope = envelope_of(data)
            except WireError:
                self.refused += 1
                continue
            if self._heeds(envelope.source):
                yield data, envelope
            else:
                self.foreign += 1

    def _heeds(self, source: bytes) -> bool:
        """The owner is who owned the name when we looked; what its predecessor had written
        before may still have waited for us."""
        if not self._owned or source == self._heeded:
            return True
        if source == self.owner:
            self._heeded = source
        return source == self.owner

    def close(self) -> None:
        """Receive no more."""
        self._poll.close()
