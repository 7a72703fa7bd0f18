"""A cable to one node that a test can cut and delay: proxies in user space.

Peers find each other by gossip, and would talk past a proxy before the hub. So the node
listens on a socket file that is moved aside for a proxy, and looks for nobody itself.
"""

import socket
import threading
import time
from collections import deque
from contextlib import suppress
from pathlib import Path

from bus.testing import eventually

PASSIVE = "{scouting: {gossip: {autoconnect: {router: [], peer: []}}}}"  # is found, does not seek
_CHUNK = 65536  # bytes


class Cable:
    """The only way between one node and all others.

    Open the node with `options` (or a process with `arguments`), then `plug` it in.

    Args:
        hub: Its endpoint.
        directory: For the node's socket; its path must be short.
    """

    def __init__(self, hub: str, directory: Path):
        self.delay = 0.0  # s, in each direction
        self.whole = threading.Event()  # cleared while the cable is cut
        self._socket, self._moved = directory / "node", directory / "moved"
        self._config = directory / "zenoh.json5"
        self._config.write_text(PASSIVE)
        host, _, port = hub.partition("/")[2].rpartition(":")
        self._listeners = [
            _Listener(self, socket.create_server(("127.0.0.1", 0)), (host, int(port)))
        ]
        self.options = {
            "connect": f"tcp/127.0.0.1:{self._listeners[0].address[1]}",
            "listen": f"unixsock-stream/{self._socket}",
            "zenoh_config": str(self._config),
        }
        self.arguments = [
            *("--connect", self.options["connect"], "--listen", self.options["listen"]),
            *("--config", self.options["zenoh_config"]),
        ]

    def plug(self) -> None:
        """Connect the node, whose session is about to be open."""
        eventually(self._socket.exists, what="the node's socket")
        self._socket.rename(self._moved)
        server = socket.socket(socket.AF_UNIX)
        server.bind(str(self._socket))
        server.listen()
        self._listeners.append(_Listener(self, server, str(self._moved)))
        self.whole.set()

    def cut(self) -> None:
        """Let no byte pass, without a word to either side."""
        self.whole.clear()

    def heal(self) -> None:
        """Let bytes pass again; those of connections that still live were only late."""
        self.whole.set()

    def close(self) -> None:
        """Close all connections."""
        self.whole.set()
        for listener in self._listeners:
            listener.close()

    def __enter__(self) -> "Cable":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class _Listener:
    """Passes bytes between whoever connects and a target."""

    def __init__(self, cable: Cable, server: socket.socket, target: tuple[str, int] | str):
        self._cable, self._server, self._target = cable, server, target
        self.address = server.getsockname()
        self._sockets = [server]
        _run(self._accept)

    def close(self) -> None:
        for sock in self._sockets:
            with suppress(OSError):
                sock.shutdown(socket.SHUT_RDWR)
            sock.close()

    def _accept(self) -> None:
        while True:
            near, _ = self._server.accept()
            self._sockets.append(near)
            _run(self._link, near)

    def _link(self, near: socket.socket) -> None:
        self._cable.whole.wait()
        far = socket.socket(socket.AF_UNIX if isinstance(self._target, str) else socket.AF_INET)
        far.connect(self._target)
        self._sockets.append(far)
        for sock in (near, far):
            if sock.family == socket.AF_INET:
                sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for one, other in ((near, far), (far, near)):
            _run(_Direction(self._cable, one, other).run)


class _Direction:
    """One direction of one connection."""

    def __init__(self, cable: Cable, source: socket.socket, sink: socket.socket):
        self._cable, self._source, self._sink = cable, source, sink
        self._line: deque[tuple[float, bytes]] = deque()
        self._came = threading.Semaphore(0)

    def run(self) -> None:
        _run(self._give)
        data = b"x"
        while data:
            self._cable.whole.wait()
            data = self._receive()
            self._line.append((time.monotonic() + self._cable.delay, data))
            self._came.release()

    def _receive(self) -> bytes:
        """Return what has come, nothing at the end."""
        try:
            return self._source.recv(_CHUNK)
        except OSError:
            return b""

    def _give(self) -> None:
        while True:
            self._came.acquire()
            due, data = self._line.popleft()
            time.sleep(max(due - time.monotonic(), 0.0))
            self._cable.whole.wait()
            if not data:
                self._sink.shutdown(socket.SHUT_WR)
                return
            self._sink.sendall(data)


def _run(target, *arguments) -> None:
    def run() -> None:
        with suppress(OSError):
            target(*arguments)

    threading.Thread(target=run, daemon=True).start()
