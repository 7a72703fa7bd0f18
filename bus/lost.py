"""Peers that a session is not linked with any more, and whether they are still there."""

import socket
import threading
import time
from abc import ABC, abstractmethod
from functools import cached_property

import zenoh

from bus.claims import OWNERS, PEERS
from bus.rpc import Request

PROBE = 0.15  # s for a connection to be accepted
DOUBT = 1.0  # s; who was not cut off may only be stopped, and come by itself
ATTEMPTS = 5  # per lost peer, after 1, 2, 4 ... s
ANSWER = 1.0  # s for the hub to say whom it has


def is_used(session: zenoh.Session) -> bool:
    """Whether somebody still wants a session: it is not closed, nor the process at its end."""
    try:
        closed = session.is_closed()
    except RuntimeError:  # another thread closes it just now
        closed = True
    return not closed and threading.main_thread().is_alive()


class Look:
    """One look for all that are lost: what was learnt for one of them serves the others."""

    def __init__(self, session: zenoh.Session):
        self.silent: set[str] = set()  # machines
        self._session = session

    @cached_property
    def at_hub(self) -> set[str] | None:
        """The peers that the hub is linked with; None when it does not answer."""
        return self._ask(PEERS)

    @cached_property
    def owners(self) -> set[str]:
        """The peers that have names, as far as the hub answers."""
        return self._ask(OWNERS) or set()

    def owners_of(self, name: str) -> set[str]:
        """Return the peers that have a name, as far as the hub answers."""
        return self._ask(OWNERS, name.encode()) or set()

    def _ask(self, key: str, payload: bytes = b"") -> set[str] | None:
        if not list(self._session.info.routers_zid()):
            return set()
        request = Request(self._session, key, payload, ANSWER)
        deadline = time.monotonic() + 2.0 * ANSWER
        while not request.done and time.monotonic() < deadline and is_used(self._session):
            request.wait(0.1)
        answer = request.values[0] if request.values else None
        return set(map(str, answer)) if isinstance(answer, list) else None


class Lost(ABC):
    """A peer that is not linked any more, though it may still be there."""

    def __init__(self) -> None:
        self.since = time.monotonic()
        self.back: float | None = None  # when it was found again
        self._attempts = 0
        self._not_before = 0.0

    @abstractmethod
    def look(self, look: Look) -> bool:
        """Try to find it; return whether it still exists, as far as one can tell."""

    @property
    def waits(self) -> bool:
        """Whether it was found, and nobody but us will bring us together."""
        return self.back is not None and time.monotonic() > self._not_before

    def attempted(self) -> bool:
        """Note that the hub was joined anew for it; return whether that was the last time."""
        self._attempts += 1
        self._not_before = time.monotonic() + 2 ** (self._attempts - 1)
        return self._attempts >= ATTEMPTS


class LostHere(Lost):
    """One on this machine: it was stopped, or it is gone, and the hub knows which.

    Args:
        share: Of our peers that are still linked. Who has lost all of them was probably the
            one that was stopped: it joins the hub anew first, which mends it for everybody.
    """

    def __init__(self, peer: str, share: float):
        super().__init__()
        self._peer = peer
        self._not_before = self.since + DOUBT * (1.0 + share)

    def look(self, look: Look) -> bool:
        if time.monotonic() < self._not_before:
            return True
        found = look.at_hub is None or self._peer in look.at_hub
        self.back = time.monotonic() if found and look.at_hub else None
        return found


class LostElsewhere(Lost):
    """One on another machine, which may be cut off.

    Args:
        addresses: The far ends of the links with it. Those that it had dialled are of no use;
            they refuse.
    """

    def __init__(self, addresses: set[tuple[str, int]]):
        super().__init__()
        self._cut = False  # it could not be reached at some time
        self._addresses = addresses

    def look(self, look: Look) -> bool:
        for address in list(self._addresses):
            if address[0] in look.silent:
                continue
            try:
                socket.create_connection(address, PROBE).close()
            except ConnectionRefusedError:
                self._addresses.discard(address)
            except OSError:
                look.silent.add(address[0])
                self._cut, self.back = True, None
            else:
                self.back = self.back or time.monotonic()
                return True
        return bool(self._addresses)

    @property
    def waits(self) -> bool:
        doubt = self.back is not None and time.monotonic() <= self.back + DOUBT
        return super().waits and (self._cut or not doubt)
