"""Links: a cut one holds up no other, and peers that lost each other meet again.

Zenoh lets ``close()`` linger for 10 s while something is unacknowledged, in the thread that
reads all links of the session: one that was cut silences all the others until it is back
(eclipse-zenoh/zenoh#1101, #2350); so does a reader on this machine that is stopped. No
setting changes that, but the sockets are ours.
"""

import zenoh
from zenoh.handlers import Callback

from bus.reunion import Reunion, stays_here
from bus.sockets import let_go
from bus.threads import adopt


def look_after_links(session: zenoh.Session, patience: float) -> None:
    """Do so for all links that a session has and will have.

    Args:
        session: A session that was opened just now.
        patience: Seconds without an acknowledgement after which a connection to another
            machine is given up.
    """
    reunion = Reunion(session)

    def on_link(event: zenoh.LinkEvent) -> None:
        adopt()
        if event.kind != zenoh.SampleKind.PUT or not _is_tcp(event.link):
            return
        let_go(0.0 if stays_here(event.link) else patience)
        reunion.began(event.link)

    def on_transport(event: zenoh.TransportEvent) -> None:
        adopt()
        if event.kind == zenoh.SampleKind.DELETE:
            reunion.ended(str(event.transport.zid))

    info = session.info  # the end of a link that failed is told as that of its transport only
    info.declare_transport_events_listener(Callback(on_transport, indirect=False), history=True)
    info.declare_link_events_listener(Callback(on_link, indirect=False), history=True)


def _is_tcp(link: zenoh.Link) -> bool:
    return link.dst.startswith(("tcp/", "tls/"))
