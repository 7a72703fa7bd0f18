"""Reads a recording ahead, so that a chunk of it never delays who plays it."""

import heapq
import threading
from collections.abc import Iterable, Iterator
from queue import Empty, Full, Queue
from typing import NamedTuple

from bus.errors import BusError, WireError
from bus.recording.heads import Recorded, split
from bus.recording.reader import Message

DEPTH = 4096  # messages
SLACK = 250_000_000  # ns; messages come in bundles, by far not so late
LOOK = 0.1  # s between looks at whether we are to end


class Item(NamedTuple):
    """A message to be played, and the port of which it is."""

    port: str
    data: bytes
    message: Recorded


def by_sent(messages: Iterable[Message], several: bool = True) -> Iterator[Item]:
    """Yield messages in the order in which they were sent; what is no message is left out.

    Args:
        several: Whether there is more than one port; the messages of one are in order.
    """
    waiting: list[tuple[int, int, Item]] = []
    for number, (port, data, arrival) in enumerate(messages):
        try:
            item = Item(port, data, split(data))
        except WireError:
            continue
        if not several:
            yield item
            continue
        heapq.heappush(waiting, (item.message.sent, number, item))
        while waiting and waiting[0][0] < arrival - SLACK:
            yield heapq.heappop(waiting)[2]
    while waiting:
        yield heapq.heappop(waiting)[2]


class ReadAhead:
    """Takes items out of an iterator in a thread of its own."""

    def __init__(self, items: Iterator[Item]):
        self.ended = False  # everything was taken
        self._items = items
        self._queue: Queue[Item | BusError | None] = Queue(DEPTH)
        self._next: Item | None = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="read ahead", daemon=True)
        self._thread.start()

    def peek(self) -> Item | None:
        """Return the next item; None when it is not read yet, or all were taken.

        Raises:
            RecordingError: The file is spoilt from here on.
        """
        if self._next is None and not self.ended:
            try:
                item = self._queue.get_nowait()
            except Empty:
                return None
            if isinstance(item, BusError):
                self.ended = True
                raise item
            self._next, self.ended = item, item is None
        return self._next

    def take(self) -> None:
        """Remove the item that was looked at."""
        self._next = None

    def close(self) -> None:
        """Read no further."""
        self._stop.set()

    def _run(self) -> None:
        try:
            for item in self._items:
                if not self._put(item):
                    return
            self._put(None)
        except BusError as error:
            self._put(error)

    def _put(self, item: Item | BusError | None) -> bool:
        while not self._stop.is_set():
            try:
                self._queue.put(item, timeout=LOOK)
                return True
            except Full:
                continue
        return False
