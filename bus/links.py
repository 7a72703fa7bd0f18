"""Links: a cut one holds up no other, and peers that lost each other meet again.

Zenoh lets ``close()`` linger for 10 s while something is unacknowledged, in the thread that
reads all links of the session: one that was cut silences all the others until it is back
(eclipse-zenoh/zenoh#1101, #2350); so does a reader on this machine that is stopped. No
setting changes that, but the sockets are ours.
"""

import time
from collections.abc import Callable
from weakref import WeakValueDictionary

import zenoh
from zenoh.handlers import Callback

from bus.lost import Look
from bus.reunion import Reunion, stays_here
from bus.sockets import endpoint_address, let_go, unlinked
from bus.threads import adopt

YOUTH = 1.0  # s; older sessions have met everybody
QUIET = 0.03  # s without a dial, once one was to be expected
TICK = 0.002  # s between looks
LONGEST_DIAL = 0.5  # s

_reunions: WeakValueDictionary[str, Reunion] = WeakValueDictionary()  # by session
_hopeless: set[int] = set()  # inodes of connections of which no link comes


def look_after_links(session: zenoh.Session, patience: float) -> None:
    """Do so for all links that a session has and will have.

    Args:
        session: A session that was opened just now.
        patience: Seconds without an acknowledgement after which a connection to another
            machine is given up.
    """
    reunion = _reunions[str(session.zid())] = Reunion(session)

    def on_link(event: zenoh.LinkEvent) -> None:
        adopt()
        if event.kind != zenoh.SampleKind.PUT or not _is_tcp(event.link):
            return
        own, other = endpoint_address(event.link.src), endpoint_address(event.link.dst)
        let_go(own, other, 0.0 if stays_here(event.link) else patience)
        reunion.began(event.link)

    def on_transport(event: zenoh.TransportEvent) -> None:
        adopt()
        is_hub = event.transport.whatami == zenoh.WhatAmI.ROUTER
        if event.kind == zenoh.SampleKind.DELETE:
            reunion.ended(str(event.transport.zid))
            if is_hub:
                reunion.left_hub()
        elif is_hub:
            reunion.joined_hub()

    info = session.info  # the end of a link that failed is told as that of its transport only
    info.declare_transport_events_listener(Callback(on_transport, indirect=False), history=True)
    info.declare_link_events_listener(Callback(on_link, indirect=False), history=True)


def alone_since(session: zenoh.Session) -> float:
    """Return since when a session has had no link with a hub, monotonic [s]; now if it has one."""
    since = reunion.alone_since if (reunion := _reunions.get(str(session.zid()))) else None
    return time.monotonic() if since is None else since


def expect_names(session: zenoh.Session, known: Callable[[], set[str]]) -> None:
    """Make the links anew with those whose names the hub knows and we do not.

    Args:
        known: Returns the sessions whose names have come here.
    """
    if reunion := _reunions.get(str(session.zid())):
        reunion.known = known


def settle(session: zenoh.Session, opened_at: float) -> None:
    """Look for no lost peers, and wait until a session dials nobody, so that it can be closed.

    What it dials while it closes Zenoh keeps for good: a ghost that is linked with others,
    and dials newcomers. A session dials the hub, and then those of whom the hub tells before
    it answers anything; a connection of which no link has been made is such a dial.

    Args:
        opened_at: When the session was open, monotonic [s].
    """
    if reunion := _reunions.get(str(session.zid())):
        reunion.end()
    if time.monotonic() < opened_at + YOUTH:
        _hear_hub(session)
    begin = quiet_from = time.monotonic()
    while (now := time.monotonic()) < begin + LONGEST_DIAL:
        if unlinked() - _hopeless:
            quiet_from = now + QUIET
        elif now >= quiet_from:
            return
        time.sleep(TICK)
    _hopeless.update(unlinked())


def _hear_hub(session: zenoh.Session) -> None:
    """Wait until a new session has heard of others, if there is a hub."""
    deadline = time.monotonic() + LONGEST_DIAL
    while not list(session.info.routers_zid()) and time.monotonic() < deadline:
        time.sleep(TICK)
    _ = Look(session).at_hub
    time.sleep(QUIET)


def _is_tcp(link: zenoh.Link) -> bool:
    return link.dst.startswith(("tcp/", "tls/"))
