"""Notices browsers that load the page."""

import contextlib
import logging
import threading
import time

import viser

from .server import PageServer

FETCHING = 10.0  # s at most from a request for the page to its websocket
DRAWING = 20.0  # s at most from there to the first picture
PICTURE = (16, 16)  # px; whoever sends one has drawn what was sent before


class _Requests(logging.Filter):
    """Hears of each request that the web server of viser answers, as it is logged."""

    def __init__(self) -> None:
        super().__init__()
        self.last = -FETCHING  # monotonic, s
        self._logger = logging.getLogger("websockets.server")
        self._logger.setLevel(logging.INFO)
        self._logger.addFilter(self)

    def filter(self, record: logging.LogRecord) -> bool:
        """Note a request; let only warnings and errors pass."""
        if str(record.msg).startswith("connection "):
            self.last = time.monotonic()
        return record.levelno > logging.INFO

    def close(self) -> None:
        self._logger.removeFilter(self)
        self._logger.setLevel(logging.NOTSET)


class Loading:
    """Whether a browser loads the page: from its first request until it has drawn the robot."""

    def __init__(self, server: PageServer):
        self._requests = _Requests()
        self._drawing_until = 0.0  # monotonic, s; 0 while none draws
        self._drawn = -FETCHING
        self._lock = threading.Lock()  # connections are told in threads
        server.on_client_connect(self._await_picture)

    def look(self) -> bool:
        """Return whether a browser loads the page now."""
        now = time.monotonic()
        with self._lock:
            fetches = self._drawn < self._requests.last and now < self._requests.last + FETCHING
            return fetches or now < self._drawing_until

    def close(self) -> None:
        """Look no more."""
        self._requests.close()

    def _await_picture(self, client: viser.ClientHandle) -> None:
        with self._lock:
            self._drawing_until = time.monotonic() + DRAWING
        with contextlib.suppress(TimeoutError, RuntimeError):  # it went away, or is very slow
            client.get_render(*PICTURE, timeout=DRAWING)
        with self._lock:
            self._drawing_until, self._drawn = 0.0, time.monotonic()
