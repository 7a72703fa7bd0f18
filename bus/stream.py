"""The keys on which an output puts its messages: each, one every 4 ms, or those of 4 ms at once."""

import zenoh
from zenoh.handlers import Callback

from bus.packing import pack

THINNED_HZ = 250.0  # rate of a thinned stream, for readers that need no more
_SLOT = round(1e9 / THINNED_HZ)  # ns
BUNDLE = 32768  # bytes after which a bundle is full


class Stream:
    """A publisher that never waits for a reader, and knows whether there is one.

    Args:
        reliable: Wait at most 20 ms for a full link, instead of dropping.
        large: Messages may be so large that small ones of other ports pass them on the link.
    """

    def __init__(
        self, session: zenoh.Session, key: str, reliable: bool = False, large: bool = False
    ):
        self.matched = False
        self.seq = 0
        self._publisher = self._declare(session, key, reliable, large)
        self._listener = self._publisher.declare_matching_listener(
            Callback(self._on_matching, indirect=False)
        )
        status: zenoh.MatchingStatus = self._publisher.matching_status  # type: ignore[assignment]
        self.matched = self.matched or status.matching

    def put(self, message: bytes) -> None:
        """Send a message that carries the next sequence number."""
        self.seq += 1
        self._publisher.put(message)

    def close(self) -> None:
        """Send no more."""
        self._listener.undeclare()
        self._publisher.undeclare()

    @staticmethod
    def _declare(session: zenoh.Session, key: str, reliable: bool, large: bool) -> zenoh.Publisher:
        control = zenoh.CongestionControl.DROP
        priority = zenoh.Priority.DATA if large else zenoh.Priority.REAL_TIME
        if reliable:  # of its own priority, so that it cannot stall the others
            control, priority = zenoh.CongestionControl.BLOCK, zenoh.Priority.INTERACTIVE_HIGH
        return session.declare_publisher(
            key, congestion_control=control, priority=priority, express=True
        )

    def _on_matching(self, status: zenoh.MatchingStatus) -> None:
        self.matched = status.matching


class ThinnedStream(Stream):
    """The first message of each 4 ms of the session's clock, and every invalid one."""

    _slot = -1

    def due(self, stamp: int, valid: bool) -> bool:
        """Whether a message of this stamp [ns] belongs to the stream and has a reader."""
        return self.matched and (not valid or stamp // _SLOT != self._slot)

    def take(self, stamp: int) -> None:
        """Note the stamp [ns] of a message that was put."""
        self._slot = stamp // _SLOT


class BundledStream(Stream):
    """Every message, those of 4 ms of the session's clock and the first of the next at once.

    An invalid message is not kept waiting, and neither are those before it.
    """

    def __init__(self, session: zenoh.Session, key: str):
        super().__init__(session, key)
        self._slot = -1
        self._messages: list[bytes] = []
        self._size = 0  # bytes

    @staticmethod
    def _declare(session: zenoh.Session, key: str, reliable: bool, large: bool) -> zenoh.Publisher:
        """Its readers have time and may lose nothing: bundles share packets when a link is slow."""
        control, priority = zenoh.CongestionControl.DROP, zenoh.Priority.DATA_HIGH
        return session.declare_publisher(key, congestion_control=control, priority=priority)

    @property
    def waiting(self) -> bool:
        """Whether messages wait for the bundle to be complete."""
        return bool(self._messages)

    def add(self, message: bytes, stamp: int, valid: bool) -> None:
        """Take a message of a stamp [ns]; put the bundle when it is complete."""
        if not self.matched:
            self._begin()  # what its last reader did not get is not for the next one
            return
        self._messages.append(message)
        self._size += len(message)
        if stamp // _SLOT != self._slot or not valid or self._size > BUNDLE:
            self._slot = stamp // _SLOT
            self.put(pack(self._messages))
            self._begin()

    def close(self) -> None:
        """Send no more; what is written so far is not kept."""
        if self._messages and self.matched:
            self.put(pack(self._messages))
        self._begin()
        super().close()

    def _begin(self) -> None:
        self._messages, self._size = [], 0
