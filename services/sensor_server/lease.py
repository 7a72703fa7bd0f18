"""One writer at a time on a command port."""


class Lease:
    """The right to command, held by the first writer until it is silent for a while.

    Args:
        duration: Silence after which another writer may take over [s].
    """

    def __init__(self, duration: float):
        self.duration = duration
        self._owner: bytes | None = None
        self._renewed = 0.0

    def owner(self, now: float) -> bytes | None:
        """Return the source that holds the lease, or None; ``now`` is monotonic [s]."""
        expired = now - self._renewed > self.duration
        return None if expired else self._owner

    def take(self, source: bytes, now: float) -> bool:
        """Take or renew the lease for ``source``; False when another one holds it."""
        if self.owner(now) not in (None, source):
            return False
        self._owner, self._renewed = source, now
        return True

    def end(self) -> None:
        """Let anybody take the lease."""
        self._owner = None
