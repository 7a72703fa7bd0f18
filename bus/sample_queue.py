"""The queue between Zenoh's threads and the main one."""

import threading
from collections import deque
from typing import Any


class SampleQueue:
    """Keeps the newest ``depth`` items; ``dropped`` counts those that newer ones pushed out.

    ``passed`` is that count as it was at the last `pop`: how many went before the item.
    """

    def __init__(self, depth: int):
        self.dropped = self.passed = 0
        self._depth = depth
        self._items: deque[Any] = deque()
        self._lock = threading.Lock()

    def push(self, item: Any) -> None:
        """Append an item, at the cost of the oldest when full."""
        if len(self._items) >= self._depth:
            with self._lock:
                if len(self._items) >= self._depth:
                    self._items.popleft()
                    self.dropped += 1
        self._items.append(item)

    def pop(self) -> Any:
        """Return the oldest item, or None."""
        if not self._items:  # the common case of a poll, without the lock
            return None
        with self._lock:
            self.passed = self.dropped
            return self._items.popleft() if self._items else None
