"""Counters of a port."""

import time
from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass
class Meter:
    """Rate of a counter over the last second or more, worked out only when asked."""

    at: float = field(default_factory=time.monotonic)
    count: int = 0
    hz: float = 0.0

    def rate(self, count: int) -> float:
        """Return the rate of ``count`` [Hz]."""
        now = time.monotonic()
        if now - self.at >= 1.0:
            self.hz = (count - self.count) / (now - self.at)
            self.at, self.count = now, count
        return self.hz


@dataclass
class InputStatistics:
    """What happened to the messages of one input."""

    received: int = 0  # handed to the service
    lost: int = 0  # missing on the wire, from the sequence numbers
    dropped: int = 0  # pushed out of this input's queue by newer ones
    refused: int = 0  # bad bytes, types, shapes, numbers, model or size
    foreign: int = 0  # from a writer that does not own the name
    late: int = 0  # so late that fresher ones must be behind them
    repeated: int = 0  # sequence numbers that did not rise

    def as_map(self) -> dict[str, Any]:
        """Return the counters as plain values."""
        return asdict(self)


@dataclass
class OutputStatistics:
    """What one output has sent."""

    written: int = 0
    bytes: int = 0

    def as_map(self) -> dict[str, Any]:
        """Return the counters as plain values."""
        return asdict(self)
