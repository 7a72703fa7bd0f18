"""The search for the places of touches, beside the detection."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import NamedTuple

from estimation.contact.localisation import NOWHERE, Localisation
from estimation.contact.touch_map import NO_MAP, TouchMap


class Found(NamedTuple):
    """What a search tells."""

    located: Localisation
    places: TouchMap


NOTHING = Found(NOWHERE, NO_MAP)


class PlaceSearch:
    """One search at a time, in a thread of its own; where runs must repeat, at once.

    Attributes:
        found: By the last search that ended and was not forgotten.
    """

    def __init__(self, beside: bool):
        self._pool = ThreadPoolExecutor(1, "places") if beside else None
        self._running: Future[Found] | None = None
        self._wanted = False
        self.found = NOTHING

    def begin(self, search: Callable[[], Found]) -> None:
        """Begin a search, when none is running."""
        if self._pool is None:
            self.found = search()
        else:
            self._running, self._wanted = self._pool.submit(search), True

    @property
    def idle(self) -> bool:
        """Whether none is running; takes the result of one that has ended, or raises its error."""
        if self._running is None or not self._running.done():
            return self._running is None
        found, self._running = self._running.result(), None
        if self._wanted:
            self.found = found
        return True

    def forget(self) -> None:
        """Nothing is touched any more; what is running is searched in vain."""
        self.found, self._wanted = NOTHING, False
