"""Whom a cut link has parted meets again soon after it is whole.

Zenoh dials peers when the hub's gossip tells of them, which happens when a link with the hub
begins, and never again. So when a lost peer can be reached while the hub stayed linked, we
leave the hub and join it anew; that takes a tenth of a second, in which no other link changes.
When the hub was lost too, Zenoh dials it, but waits a second and more for an answer to what it
sent into the cut link; we let it dial again as soon as somebody answers us.
"""

import socket
import threading
import time
from contextlib import suppress

import zenoh

from bus.sockets import abandon_dials, close_connection, endpoint_address

FIRST_PAUSE, LAST_PAUSE = 0.1, 1.0  # s between looks for a peer, soon after its loss and later
PROBE = 0.15  # s for a connection to be accepted
GOSSIP = 0.3  # s after which the hub's gossip of a new link has had its effect
DOUBT = 1.0  # s; who could be reached all the time may only be stopped, and comes by itself
ATTEMPTS = 5  # per lost peer, after 1, 2, 4 ... s


class Lost:
    """A peer that is not linked any more, though it may still be there.

    Args:
        addresses: The far ends of the links with it. Those that it had dialled are of no use;
            they refuse.
    """

    def __init__(self, addresses: set[tuple[str, int]]):
        self.since = time.monotonic()
        self.cut = False  # it could not be reached at some time
        self.back: float | None = None  # when it could be reached again
        self._addresses = addresses
        self._attempts = 0
        self._not_before = 0.0

    def look(self, silent: set[str]) -> bool:
        """Try to reach it, unless its machine is among the silent ones, which grow.

        Return whether it still exists, as far as one can tell.
        """
        for address in list(self._addresses):
            if address[0] in silent:
                continue
            try:
                socket.create_connection(address, PROBE).close()
            except ConnectionRefusedError:
                self._addresses.discard(address)
            except OSError:
                silent.add(address[0])
                self.cut, self.back = True, None
            else:
                self.back = self.back or time.monotonic()
                return True
        return bool(self._addresses)

    @property
    def waits(self) -> bool:
        """Whether it can be reached, and nobody but us will bring us together."""
        now = time.monotonic()
        if self.back is None or now < self._not_before:
            return False
        return self.cut or now > self.back + DOUBT

    def attempted(self) -> bool:
        """Note that the hub was joined anew for it; return whether that was the last time."""
        self._attempts += 1
        self._not_before = time.monotonic() + 2 ** (self._attempts - 1)
        return self._attempts >= ATTEMPTS


class Reunion:
    """Hears of the links to other machines that a session gets and loses."""

    def __init__(self, session: zenoh.Session):
        self._session = session
        self._lost: dict[str, Lost] = {}
        self._links: dict[str, list[zenoh.Link]] = {}  # by peer; the two that meet dial both
        self._began: dict[str, float] = {}
        self._lock = threading.Lock()
        self._watching = False

    def began(self, link: zenoh.Link) -> None:
        """Note a new link."""
        peer = str(link.zid)
        self._lost.pop(peer, None)
        self._links.setdefault(peer, []).append(link)
        self._began[peer] = time.monotonic()

    def ended(self, peer: str) -> None:
        """Note that a peer is not linked any more; look for it from time to time."""
        links = self._links.pop(peer, [])
        if not links:
            return
        with self._lock:
            self._lost[peer] = Lost({endpoint_address(link.dst) for link in links})
            if not self._watching:
                self._watching = True
                threading.Thread(target=self._watch, daemon=True, name="reunion").start()

    def _watch(self) -> None:
        while self._any_lost() and not self._session.is_closed():
            oldest = min((lost.since for lost in list(self._lost.values())), default=0.0)
            elapsed = time.monotonic() - oldest
            time.sleep(min(FIRST_PAUSE + 0.02 * elapsed, LAST_PAUSE))
            with suppress(zenoh.ZError):  # closed meanwhile
                self._look()

    def _any_lost(self) -> bool:
        with self._lock:
            self._watching = bool(self._lost)
            return self._watching

    def _look(self) -> None:
        linked = {str(peer) for peer in self._session.info.peers_zid()}
        silent: set[str] = set()
        for peer, lost in list(self._lost.items()):
            was_back = lost.back
            if peer in linked or not lost.look(silent):
                self._lost.pop(peer, None)
            elif lost.waits and self._rejoin() and lost.attempted():
                self._lost.pop(peer, None)
            if lost.back and not was_back and not self._session.info.routers_zid():
                abandon_dials()

    def _rejoin(self) -> bool:
        """Leave the hub, unless it has just been joined; Zenoh joins it again."""
        for router in map(str, self._session.info.routers_zid()):
            links = self._links.get(router, [])
            if links and time.monotonic() - self._began[router] > GOSSIP:
                ends = [(endpoint_address(link.src), endpoint_address(link.dst)) for link in links]
                return any(close_connection(own, other) for own, other in ends)
        return False
