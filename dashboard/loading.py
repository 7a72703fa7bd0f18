"""Notices browsers that load the page."""

import contextlib
import threading
import time

import viser

from .server import PageServer
from .tcp_table import is_at, sockets

FETCHING = 10.0  # s at most from a request for the page to its websocket
DRAWING = 20.0  # s at most from there to the first picture
PICTURE = (16, 16)  # px; whoever sends one has drawn what was sent before


class Loading:
    """Whether a browser loads the page: from its first request until it has drawn the robot.

    Where the machine does not show its sockets, from its websocket on.
    """

    def __init__(self, server: PageServer):
        self._port = server.get_port()
        self._seen = self._visitors()
        self._until = 0.0  # monotonic, s
        self._lock = threading.Lock()  # connections are told in threads
        server.on_client_connect(self._await_picture)

    def look(self) -> bool:
        """Return whether a browser loads the page now."""
        visitors = self._visitors()
        with self._lock:
            if visitors - self._seen:
                self._until = time.monotonic() + FETCHING
            self._seen = visitors
            return time.monotonic() < self._until

    def _visitors(self) -> set[str]:
        """Addresses from which the page was asked for, of late.

        They are of this machine, as the page is served there alone: a connection that is
        over stays in the table of whoever closed it, of us or of the browser.
        """
        ours = {one.remote for one in sockets() if is_at(one.local, self._port)}
        return ours | {one.local for one in sockets() if is_at(one.remote, self._port)}

    def _await_picture(self, client: viser.ClientHandle) -> None:
        with self._lock:
            self._seen |= self._visitors()
            self._until = time.monotonic() + DRAWING
        with contextlib.suppress(TimeoutError, RuntimeError):  # it went away, or is very slow
            client.get_render(*PICTURE, timeout=DRAWING)
        with self._lock:
            self._until = 0.0
