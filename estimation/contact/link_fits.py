"""What every way to find a touch tells: how well each link explains it, and where."""

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from estimation.contact.limb_touch import LimbTouch

Array = np.ndarray


class Places(NamedTuple):
    """Places that were tried, one link after the other."""

    links: list[str]
    count: list[int]  # places of each link
    point: Array  # (P, 3) m, in the frame of the link
    weight: Array  # (P,) log-likelihood

    def split(self, values: Array) -> list[Array]:
        """Return the values of all places link by link."""
        return np.split(values, np.cumsum(self.count)[:-1])


class LinkFits(NamedTuple):
    """The best touch on each of k links, in their frames."""

    links: list[str]
    weight: Array  # (k,) log-likelihood of a touch anywhere on the link
    point: Array  # (k, 3) m, of the best touch
    force: Array  # (k, 3) N, on the robot
    covariance: Array  # (k, 6, 6) of [point, force]
    misfit: float  # log-likelihood of a free wrench ahead of the best touch, 0 or more
    places: Callable[[], Places]  # computed for whoever looks


class PlaceMethod(Protocol):
    """A way to find the place of a touch, sample by sample.

    A method may remember touches; ``forget`` ends what it remembers of one limb.
    """

    def fit(self, touch: LimbTouch) -> LinkFits: ...

    def forget(self, subtree: int) -> None: ...
