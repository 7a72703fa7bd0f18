"""Whom a cut link, or a stop, has parted meets again soon after.

Zenoh dials peers when the hub's gossip tells of them, which happens when a link with the hub
begins, and never again. So when a lost peer can be reached while the hub stayed linked, we
leave the hub and join it anew; that takes a tenth of a second, in which no other link changes.
When the hub was lost too, Zenoh dials it, but waits a second and more for an answer to what it
sent into the cut link; we let it dial again as soon as somebody answers us.

On one machine nothing is cut, but a process that was stopped for about the lease can be given
up by its peers and not by the hub; the hub is asked whether it still has it. (Whether its
address answers says nothing there: ports are used again.) Nor need two have been linked ever:
gossip is told once, and a dial that it causes fails where one of them is stopped just then, or
slow. So some time after it has joined a hub a session asks who else has, and looks for them too.
And who is linked may be deaf or dumb all the same, when links begin on a loaded machine: the hub
knows names of somebody, and we none. Such a link is closed, which makes it a lost peer's.

The thread that looks is no daemon: one that Python's end finds in Zenoh brings the process down.
"""

import threading
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress

import zenoh

from bus.lost import Look, Lost, LostElsewhere, LostHere, is_used
from bus.sockets import abandon_dials, close_connection, endpoint_address
from bus.unheard import LOOK, Unheard

FIRST_PAUSE, LAST_PAUSE = 0.1, 1.0  # s between looks for a peer, soon after its loss and later
SLICE = 0.05  # s between looks at whether we are to end
GOSSIP = 0.3  # s after which the hub's gossip of a new link has had its effect
GATHERING = 2.0  # s without a new link, after which all who have joined a hub should be linked
NAMELESS = 3  # looks, so long apart, at which nothing has come of a peer's names


class Reunion:
    """Hears of the links that a session gets and loses."""

    def __init__(self, session: zenoh.Session):
        self._session = session
        self._lost: dict[str, Lost] = {}
        self._links: dict[str, list[zenoh.Link]] = {}  # by peer; the two that meet dial both
        self._began: dict[str, float] = {}
        self._given_up: set[str] = set()
        self._unheard = Unheard()
        self.known: Callable[[], set[str]] | None = None  # the sessions whose names have come
        self._nameless: Counter[str] = Counter()
        self._gathered_at: float | None = None
        self.alone_since: float | None = time.monotonic()  # without a hub; None with one
        self._lock = threading.Lock()
        self._watching = False
        self._ended = threading.Event()

    def began(self, link: zenoh.Link) -> None:
        """Note a new link."""
        peer = str(link.zid)
        self._lost.pop(peer, None)
        self._given_up.discard(peer)
        self._links.setdefault(peer, []).append(link)
        self._began[peer] = time.monotonic()
        if self._gathered_at is not None:
            self._gathered_at = time.monotonic() + GATHERING
        with self._lock:
            self._unheard.began(link)
            self._start()

    def ended(self, peer: str) -> None:
        """Note that a peer is not linked any more; look for it from time to time."""
        self._seek(peer, self._links.pop(peer, []))

    def joined_hub(self) -> None:
        """Note a link with a hub; see later who else has joined it."""
        self.alone_since = None
        with self._lock:
            self._gathered_at = time.monotonic() + GATHERING
            self._start()

    def left_hub(self) -> None:
        """Note that the link with the hub has ended."""
        self.alone_since = time.monotonic()

    def end(self) -> None:
        """Look for nobody any more."""
        self._ended.set()

    def _seek(self, peer: str, links: list[zenoh.Link]) -> None:
        with self._lock:
            self._lost[peer] = self._describe(peer, links)
            self._start()

    def _start(self) -> None:
        if not self._watching:
            self._watching = True
            # said outright: Zenoh's threads, which start it, count as daemons and pass that on
            threading.Thread(target=self._watch, name="reunion", daemon=False).start()

    def _describe(self, peer: str, links: list[zenoh.Link]) -> Lost:
        if not all(map(stays_here, links)):
            return LostElsewhere({endpoint_address(link.dst) for link in links})
        return LostHere(peer, len(self._links) / (len(self._links) + len(self._lost) + 1))

    def _watch(self) -> None:
        while self._any_awaited() and self._is_used():
            if self._rested(self._pause()):
                with suppress(zenoh.ZError, RuntimeError):  # closed meanwhile, or just now
                    self._look()

    def _pause(self) -> float:
        now, lost = time.monotonic(), list(self._lost.values())
        longest = LOOK if self._unheard.any else LAST_PAUSE
        if lost:
            elapsed = now - min(each.since for each in lost)
            return min(FIRST_PAUSE + 0.02 * elapsed, longest)
        gathered_at = now + longest if self._gathered_at is None else self._gathered_at
        return min(max(gathered_at - now, SLICE), longest)

    def _rested(self, pause: float) -> bool:
        """Wait; return whether the session is still used then."""
        until = time.monotonic() + pause
        while self._is_used() and (remaining := until - time.monotonic()) > 0.0:
            self._ended.wait(min(remaining, SLICE))
        return self._is_used()

    def _is_used(self) -> bool:
        return is_used(self._session) and not self._ended.is_set()

    def _any_awaited(self) -> bool:
        with self._lock:
            awaited = bool(self._lost) or self._gathered_at is not None
            self._watching = awaited or self._unheard.any
            return self._watching

    def _look(self) -> None:
        self._unheard.look()
        linked = {str(peer) for peer in self._session.info.peers_zid()}
        look = Look(self._session)
        self._count(look, linked)
        for peer, lost in list(self._lost.items()):
            was_back = lost.back
            if peer in linked or not lost.look(look):
                self._lost.pop(peer, None)
            elif lost.waits and self._rejoin() and lost.attempted():
                self._lost.pop(peer, None)
                self._given_up.add(peer)
            if lost.back and not was_back and not self._session.info.routers_zid():
                abandon_dials()

    def _count(self, look: Look, linked: set[str]) -> None:
        """Miss those whom the hub has and we have not, some time after it was joined."""
        if self._gathered_at is None or time.monotonic() < self._gathered_at:
            return
        self._gathered_at = None
        others = (look.at_hub or set()) - linked - {str(self._session.zid())}
        for peer in others - self._lost.keys() - self._given_up:
            self._lost[peer] = LostHere(peer, 0.0)
        self._doubt(look, linked)

    def _doubt(self, look: Look, linked: set[str]) -> None:
        """Close the links with those whose names do not come, though the hub has them."""
        if self.known is None:
            return
        doubtful = (look.owners & linked) - self.known()
        self._nameless = Counter({peer: self._nameless[peer] + 1 for peer in doubtful})
        if doubtful:
            self._gathered_at = time.monotonic() + GATHERING
        self._close({peer for peer in doubtful if self._nameless[peer] % NAMELESS == 0})

    def _close(self, peers: set[str]) -> bool:
        """Close all links with some; return whether there was one."""
        links = [link for link in self._session.info.links() if str(link.zid) in peers]
        ends = [(endpoint_address(link.src), endpoint_address(link.dst)) for link in links]
        return sum(close_connection(own, other) for own, other in ends) > 0

    def _rejoin(self) -> bool:
        """Leave the hub, unless it has just been joined; Zenoh joins it again."""
        routers = set(map(str, self._session.info.routers_zid()))
        if any(time.monotonic() < self._began.get(router, 0.0) + GOSSIP for router in routers):
            return False
        return self._close(routers)


def stays_here(link: zenoh.Link) -> bool:
    """Whether a link does not leave this machine: nothing can be cut then."""
    return endpoint_address(link.src)[0] == endpoint_address(link.dst)[0]
