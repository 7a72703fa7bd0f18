"""Proof that a recording is whole: gaps in the sequence numbers of each port."""

from dataclasses import asdict, dataclass

from bus.envelope import Envelope, opened_at
from bus.sequence import Sequences


@dataclass
class Losses:
    """What of one port was recorded, and what is known to be missing."""

    recorded: int = 0
    lost: int = 0  # missing in the sequence numbers of a source, its last ones included
    refused: int = 0  # bytes that are no message, or too many of them
    repeated: int = 0  # sequence numbers that did not rise
    foreign: int = 0  # of writers that did not own the name
    unheard: int = 0  # written by who opened the port meanwhile, before it was heard of
    sources: int = 0  # openings of the port that were seen

    def __post_init__(self) -> None:
        self._sequences = Sequences()
        self._seen: set[bytes] = set()
        self.latest: tuple[bytes, int] = b"", 0  # source and sequence number of the last one

    def note(self, envelope: Envelope, since: int) -> bool:
        """Count a message; return whether it is to be recorded.

        Args:
            since: When the recording began, wall time [ns].
        """
        source, seq = envelope.source, envelope.seq
        gap = self._sequences.gap(source, seq)
        if gap < 0:
            self.repeated += 1
            return False
        if source not in self._seen:
            self._seen.add(source)
            self.sources = len(self._seen)
            self.unheard += seq - 1 if opened_at(source) > since else 0
        self.latest = source, seq
        self.lost += gap
        self.recorded += 1
        return True

    def as_map(self) -> dict[str, int]:
        """Return the counters by name."""
        return asdict(self)
