"""Which located touches are sure enough for others to reckon with them."""

from typing import NamedTuple

import numpy as np

from estimation.contact.localisation import Localisation
from robot_model import Robot

Array = np.ndarray
SURE, UNSURE = 0.5, 0.35  # probabilities from and below which a place is told, and no more
STEP = 0.005  # m; nearer than that the last point stands, so that noise moves nothing


class TouchPoint(NamedTuple):
    """Where a sub-tree is touched: a point (3,) [m] in the frame of a link."""

    link: str
    point: Array


class TouchPoints:
    """The best place of every touched sub-tree, where it is at least as probable as not.

    The link that is told stays so until it is clearly less; nothing is told of a sub-tree
    that is touched nobody knows where.
    """

    def __init__(self, robot: Robot):
        self._robot = robot
        self._told: dict[int, TouchPoint] = {}

    def update(self, touched: list[int], located: Localisation) -> list[TouchPoint]:
        """Return the places to tell now, by the indices of the sub-trees that are touched."""
        best: dict[int, TouchPoint] = {}
        seen: set[int] = set()
        for one in located.hypotheses:  # best first
            subtree = self._robot.subtree_of(one.links[0])
            if subtree in seen or subtree not in touched:
                continue
            seen.add(subtree)
            if one.probability >= self._least(subtree, one.links[0]):
                best[subtree] = self._steady(subtree, TouchPoint(one.links[0], one.point))
        self._told = best
        return [best[i] for i in sorted(best)]

    def _least(self, subtree: int, link: str) -> float:
        told = self._told.get(subtree)
        return UNSURE if told is not None and told.link == link else SURE

    def _steady(self, subtree: int, new: TouchPoint) -> TouchPoint:
        """The last place, if the new one is hardly another."""
        old = self._told.get(subtree)
        return new if old is None or self._moved(old, new) else old

    @staticmethod
    def _moved(old: TouchPoint, new: TouchPoint) -> bool:
        return old.link != new.link or float(np.linalg.norm(new.point - old.point)) > STEP
