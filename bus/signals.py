"""SIGTERM and SIGINT end a process by a plain flag.

A handler that does more (an Event, a lock, a close) can deadlock with what the main
thread is just doing; the loops look at the flag instead.
"""

import signal
import threading
from typing import Any

_HANDLED = (signal.SIGTERM, signal.SIGINT)


class StopFlag:
    """Set for ever by the first signal; one per process."""

    def __init__(self) -> None:
        self.set = False
        self._users = 0
        self._before: dict[int, Any] = {}

    def install(self) -> bool:
        """Take over the signals, in the main thread only; return whether that was possible."""
        if threading.current_thread() is not threading.main_thread():
            return False
        if self._users == 0:
            self._before = {number: signal.signal(number, self._handle) for number in _HANDLED}
        self._users += 1
        return True

    def uninstall(self) -> None:
        """Give the signals back when the last user has gone."""
        self._users -= 1
        if self._users == 0 and threading.current_thread() is threading.main_thread():
            for number, handler in self._before.items():
                signal.signal(number, handler)

    def _handle(self, number: int, frame: Any) -> None:
        self.set = True


stop_flag = StopFlag()
