"""The requests that an application sends once all its services are ready."""

import threading
import time

from bus import BusError, Node
from deploy.launcher.logs import Log
from deploy.launcher.parts import Request

PAUSE = 0.5  # [s] between attempts


class Requests:
    """Sends requests one after the other, beside the launcher's loop.

    A service that is asked to tare while the robot still settles refuses; the
    request is repeated for as long as its ``retry`` says.
    """

    def __init__(self, node: Node, requests: list[Request], log: Log):
        self._node = node
        self._requests = requests
        self._log = log
        self._cancelled = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Begin; returns at once."""
        self._thread = threading.Thread(target=self._run, name="requests")
        self._thread.start()

    def cancel(self) -> None:
        """Send no more; returns at once."""
        self._cancelled.set()

    def join(self) -> None:
        """Wait for the one under way; it ends with its service."""
        if self._thread:
            self._thread.join()

    def _run(self) -> None:
        for request in self._requests:
            answer = self._send(request)
            if not self._cancelled.is_set():
                self._log.say("launcher", answer)

    def _send(self, request: Request) -> str:
        what = f"{request.verb} {request.port}"
        deadline = time.monotonic() + request.retry
        while not self._cancelled.is_set():
            try:
                self._node.call(request.port, request.verb, request.args, timeout=request.timeout)
                return f"{what}: done"
            except BusError as error:
                if time.monotonic() > deadline or self._cancelled.wait(PAUSE):
                    return f"{what}: {error}"
        return f"{what}: cancelled"
