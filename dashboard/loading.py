"""Notices browsers that load the page."""

import contextlib
import threading
import time

import viser

from .server import PageServer
from .tcp_table import sockets

FETCHING = 10.0  # s at most from a request for the page to its websocket
DRAWING = 20.0  # s at most from there to the first picture
PICTURE = (16, 16)  # px; whoever sends one has drawn what was sent before


class Loading:
    """Whether a browser loads the page: from its first request until it has drawn the robot.

    Where the machine does not show its sockets, from its websocket on.
    """

    def __init__(self, server: PageServer):
        self._port = server.get_port()
        self._seen = self._remotes()
        self._until = 0.0  # monotonic, s
        self._lock = threading.Lock()  # connections are told in threads
        server.on_client_connect(self._await_picture)

    def look(self) -> bool:
        """Return whether a browser loads the page now."""
        remotes = self._remotes()
        with self._lock:
            if remotes - self._seen:
                self._until = time.monotonic() + FETCHING
            self._seen = remotes
            return time.monotonic() < self._until

    def _remotes(self) -> set[str]:
        return {one.remote for one in sockets(self._port)}

    def _await_picture(self, client: viser.ClientHandle) -> None:
        with self._lock:
            self._seen |= self._remotes()
            self._until = time.monotonic() + DRAWING
        with contextlib.suppress(TimeoutError, RuntimeError):  # it went away, or is very slow
            client.get_render(*PICTURE, timeout=DRAWING)
        with self._lock:
            self._until = 0.0
