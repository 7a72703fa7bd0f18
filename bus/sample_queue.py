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
        items = self._items
        if len(items) < self._depth:
            items.append(item)
            return
        with self._lock:
            items.append(item)  # first, so that it never looks empty
            if len(items) > self._depth:
                items.popleft()
                self.dropped += 1

    def pop(self) -> Any:
        """Return the oldest item, or None."""
        if not self._items:  # the common case of a poll, without the lock
            return None
        with self._lock:
            self.passed = self.dropped
            return self._items.popleft() if self._items else None
