"""Parts of a loop that run less often than the loop."""


class Rhythm:
    """Says when something is due; lost beats are not made up for."""

    def __init__(self, rate: float):
        self._period = 1.0 / rate  # [s]
        self._next = -float("inf")

    def due(self, now: float) -> bool:
        """Whether a period has passed since the last time this was true; ``now`` in s."""
        if now < self._next:
            return False
        following = self._next + self._period
        self._next = following if following > now else now + self._period
        return True
