"""Counting gaps in sequence numbers, for each writer by itself."""

_WRITERS = 64  # remembered; a key with more writers than this counts no gaps for the oldest


class Sequences:
    """The last sequence number of each source."""

    def __init__(self) -> None:
        self._last: dict[bytes, int] = {}

    def gap(self, source: bytes, seq: int) -> int:
        """Return how many messages are missing before this one; -1 when it is not a new one."""
        last = self._last.get(source)
        if last == seq - 1:
            self._last[source] = seq
            return 0
        if last is None:
            if len(self._last) >= _WRITERS:
                del self._last[next(iter(self._last))]
            self._last[source] = seq
            return 0
        if seq <= last:
            return -1
        self._last[source] = seq
        return seq - last - 1
