"""New links of which nothing is read are closed; then they are made anew.

On a loaded machine Zenoh now and then never begins to read a link, when opening it took longer
than it allows. It sends on it all the same and counts the other side as a peer for good, while all
that the other side says waits in the kernel, which alone knows of it.
"""

import logging
import time

import zenoh

from bus.sockets import Ends, close_connection, endpoint_address, read_and_waiting

logger = logging.getLogger(__name__)

LOOK = 0.5  # s between looks; whoever is linked says something as often
PATIENCE = 8  # looks: they stop when the process does, as a clock would not


class Unheard:
    """The new links of a session, until something has been read from each."""

    def __init__(self) -> None:
        self._waits: dict[Ends, int] = {}  # looks at which bytes waited
        self._read: dict[Ends, int] = {}  # bytes, at the first look
        self._due = 0.0  # monotonic [s]

    def began(self, link: zenoh.Link) -> None:
        """Note a new link."""
        self._waits[endpoint_address(link.src), endpoint_address(link.dst)] = 0

    @property
    def any(self) -> bool:
        """Whether there are links to look at."""
        return bool(self._waits)

    def look(self) -> None:
        """Forget the links that are heard or gone; close those that stay mute."""
        if not self._waits or time.monotonic() < self._due:
            return
        self._due = time.monotonic() + LOOK
        found = read_and_waiting()
        for ends in list(self._waits):
            if ends not in found or self._is_settled(ends, *found[ends]):
                self._waits.pop(ends)
                self._read.pop(ends, None)

    def _is_settled(self, ends: Ends, read: int, waiting: int) -> bool:
        self._waits[ends] += waiting > 0
        if read > self._read.setdefault(ends, read):
            return True
        mute = self._waits[ends] >= PATIENCE and close_connection(*ends)
        if mute:
            logger.warning(
                "a link with %s:%d was made anew: %d bytes wait, nothing but %d was ever read",
                *(*ends[1], waiting, read),
            )
        return mute
