"""Proof that a recording is whole: gaps in the sequence numbers of each port."""

from dataclasses import asdict, dataclass

from bus.envelope import Envelope
from bus.sequence import Sequences


@dataclass
class Losses:
    """What of one port was recorded, and what is known to be missing."""

    recorded: int = 0
    lost: int = 0  # missing in the sequence numbers of a source
    refused: int = 0  # bytes that are no message, or too many of them
    repeated: int = 0  # sequence numbers that did not rise
    sources: int = 0  # openings of the port that were seen

    def __post_init__(self) -> None:
        self._sequences = Sequences()
        self._seen: set[bytes] = set()

    def note(self, envelope: Envelope) -> bool:
        """Count a message; return whether it is to be recorded."""
        gap = self._sequences.gap(envelope.source, envelope.seq)
        if gap < 0:
            self.repeated += 1
            return False
        self._seen.add(envelope.source)
        self.sources = len(self._seen)
        self.lost += gap
        self.recorded += 1
        return True

    def as_texts(self) -> dict[str, str]:
        """Return the counters as texts, for the metadata of a file."""
        return {name: str(value) for name, value in asdict(self).items()}
