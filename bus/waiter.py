"""The lock on which a process's main thread waits for its ports."""

import threading

SLICE = 0.1  # s; a signal handler may only assign a flag, so long waits look at it this often


class Waiter:
    """Woken from any thread; several wakes before a wait count as one."""

    def __init__(self) -> None:
        self.waits = 0  # so far
        self._lock = threading.Lock()
        self._lock.acquire()

    def wake(self) -> None:
        """End the present or the next wait."""
        if self._lock.locked():  # else already awake
            try:
                self._lock.release()
            except RuntimeError:
                pass  # another thread was faster

    def wait(self, timeout: float) -> bool:
        """Wait at most ``timeout`` and at most 0.1 s; return whether something woke us."""
        self.waits += 1
        return self._lock.acquire(timeout=min(max(timeout, 0.0), SLICE))
