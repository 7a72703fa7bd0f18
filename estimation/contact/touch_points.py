"""Which located touches are sure enough for others to reckon with them."""

from typing import NamedTuple

import numpy as np

from estimation.contact.localisation import Localisation
from robot_model import Robot

Array = np.ndarray
LEAST = 0.5  # probability of a place
STEP = 0.005  # m; nearer than that the last point stands, so that noise moves nothing


class TouchPoint(NamedTuple):
    """Where a sub-tree is touched: a point (3,) [m] in the frame of a link."""

    link: str
    point: Array


class TouchPoints:
    """The best place of every touched sub-tree, once it is at least as probable as not.

    Probabilities of one place fall for a moment while a touch moves; a place that was
    told stands until another is sure or the touch has ended.
    """

    def __init__(self, robot: Robot):
        self._robot = robot
        self._told: dict[int, TouchPoint] = {}

    def update(self, touched: list[int], located: Localisation) -> list[TouchPoint]:
        """Return the places to tell now, by the indices of the sub-trees that are touched."""
        self._told = {i: place for i, place in self._told.items() if i in touched}
        best: dict[int, TouchPoint] = {}
        for one in located.hypotheses:  # best first
            subtree = self._robot.subtree_of(one.links[0])
            if one.probability >= LEAST and subtree in touched:
                best.setdefault(subtree, TouchPoint(one.links[0], one.point))
        for subtree, place in best.items():
            if self._moved(self._told.get(subtree), place):
                self._told[subtree] = place
        return [self._told[i] for i in sorted(self._told)]

    @staticmethod
    def _moved(old: TouchPoint | None, new: TouchPoint) -> bool:
        if old is None or old.link != new.link:
            return True
        return float(np.linalg.norm(new.point - old.point)) > STEP
