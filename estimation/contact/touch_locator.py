"""Where each touched limb is touched, as long as it is touched."""

from collections.abc import Sequence
from math import expm1
from typing import NamedTuple

import numpy as np

from estimation.contact.contact_rows import ContactRows
from estimation.contact.link_fits import LinkFits, PlaceMethod
from estimation.contact.localisation import NOWHERE, Hypothesis, Localisation, ranked
from estimation.contact.localiser import Localiser
from estimation.contact.place_filter import PlaceFilter
from estimation.contact.row_covariance import RowCovariance, RowNoise
from estimation.contact.row_layout import RemovedWrenches
from estimation.contact.touch_map import TouchMap, touch_map
from robot_model.messages import SensorFrame

Array = np.ndarray
SUDDEN = 2.0  # standard deviations of a limb's wrench from the smooth one: it changes


class Look(NamedTuple):
    """What the places of the touches are searched from; the locator does not change it later."""

    stamp: int  # ns
    frame: SensorFrame  # whose flags count
    touch: Array  # (nv,) smooth rows
    posture: Array  # (nq,) that belongs to them
    limbs: dict[int, RemovedWrenches]  # touched sub-trees, and what must not disturb each
    ended: set[int]  # sub-trees whose touch has ended since the last look
    model_error: Array | float  # standard deviation of what the model predicts, (nv,)
    bias: Array  # (nv, nv) covariance of what a tare leaves open
    floor: Array | None  # (nv,) variance that a calibration found
    method: PlaceMethod


class TouchLocator:
    """Smooths the rows of the touches, and finds the place of each touch from them.

    Each limb is looked at for itself: other touched limbs and those that are not
    valid are made blind. What is held is known better with every look.

    Rows may be added while another thread searches: a search needs nothing but its look. One
    search at a time.

    Args:
        rows: From which rows, posture, tare and calibration are taken.
        noise: Standard deviations of the sensors.
        smoothing: Time constant [s].
        method: As of ``Localiser``.
    """

    def __init__(self, rows: ContactRows, noise: RowNoise, smoothing: float, method: str):
        self._rows = rows
        self._at = ContactRows(rows.robot, rows.support, rows.layout)  # of the search
        self._covariance = RowCovariance(self._at, noise)
        self._localiser = Localiser(self._at, method)
        self._smooth = np.zeros(rows.layout.model.nv)
        self._posture = rows.q.copy()  # as smooth as the rows, so that it belongs to them
        self.smoothing, self._name, self._method = smoothing, method, self._localiser.method
        self._held: set[int] = set()  # sub-trees that were looked at
        self._ended: set[int] = set()
        self._fits: dict[int, LinkFits] = {}  # by sub-tree, of the last search
        self._filters: dict[int, PlaceFilter] = {}
        self._searched = 0  # ns, stamp of the last look
        self.reset()

    def configure(self, smoothing: float, method: str) -> None:
        """Change the time constant [s] and the method; ValueError for an unknown one."""
        self.smoothing = smoothing
        if method != self._name:
            self._name, self._method = method, self._localiser.make(method)
            self.keep(())

    def reset(self) -> None:
        """Forget all touches; the next rows are taken as they are."""
        self._smooth[:] = 0.0
        self._fresh = True
        self.keep(())

    def keep(self, touched: Sequence[int]) -> None:
        """Forget the touches of the limbs that are touched no longer."""
        if self._held.difference(touched):
            self._ended |= self._held.difference(touched)
            self._held &= set(touched)

    def change(self, touch: Array) -> Array:
        """How far tared rows, (nv,), are from the smooth ones."""
        return touch - self._smooth

    def add(self, touch: Array, period: float, change: float = 0.0) -> None:
        """Take tared rows, ``period`` seconds after the last ones.

        A wrench that changes suddenly, as in a tap, is smoothed less: the smooth rows stay
        near it.

        Args:
            touch: (nv,) rows.
            period: s.
            change: Largest wrench of a sub-tree in ``change`` of the rows, in standard
                deviations.
        """
        blend = 1.0 if self._fresh else -expm1(-period / self.smoothing)
        blend = max(blend, 1.0 - (SUDDEN / max(change, SUDDEN)) ** 2)
        self._smooth += blend * self.change(touch)
        self._posture += blend * (self._rows.q - self._posture)
        self._fresh = False

    def look(
        self,
        frame: SensorFrame,
        touched: Sequence[int],
        unjudged: Sequence[int],
        model_error: Array | float,
        stamp: int,
    ) -> Look:
        """Return what the places of all touches are searched from.

        Args:
            frame: Of the last rows; its flags count.
            touched: Indices of the touched sub-trees.
            unjudged: Indices of those that cannot be judged.
            model_error: Standard deviation of what the model predicts, (nv,).
            stamp: Time of the rows [ns].
        """
        rows, ended = self._rows, self._ended
        self._ended = set()
        self._held.update(touched)
        return Look(
            stamp=stamp,
            frame=frame,
            touch=self._smooth.copy(),
            posture=self._posture.copy(),
            limbs={limb: self._others(limb, {*touched, *unjudged}) for limb in touched},
            ended=ended,
            model_error=model_error,
            bias=rows.bias.covariance.copy(),
            floor=rows.floor,
            method=self._method,
        )

    def _others(self, limb: int, felt: set[int]) -> RemovedWrenches:
        supports = self._rows.removed.subtrees
        return self._rows.removing(sorted(felt - {limb} - set(supports)))

    def search(self, look: Look) -> Localisation:
        """Locate the touch of every touched limb, at the posture of the smooth rows.

        Probabilities of one limb sum to one with its share of none. ``none_probability`` is
        that the touch of at least one limb is on none of its links.
        """
        self._take(look)
        period, self._searched = (look.stamp - self._searched) * 1e-9, look.stamp
        for limb, removed in look.limbs.items():
            touch = self._at.remove(look.touch.copy(), removed)
            self._covariance.update(look.frame, removed, look.model_error)
            fits = self._localiser.fit(touch, self._covariance, limb)
            if fits is not None:
                self._fits[limb] = self._filter(limb).add(fits, period)
        return _together([ranked(fits) for fits in self._fits.values()])

    def _take(self, look: Look) -> None:
        """Forget what has ended, and be where the look was taken."""
        for limb in look.ended & self._fits.keys():
            del self._fits[limb], self._filters[limb]
            self._localiser.method.forget(limb)
        self._localiser.method = look.method
        self._at.put(look.posture)
        self._at.bias.covariance[:] = look.bias
        self._at.floor = look.floor

    def map(self) -> TouchMap:
        """Return the places of the touches that the last ``search`` found."""
        robot, placed = self._at.robot, self._at.place_links()
        base = placed[robot.links.index(robot.base_link)].inverse()
        places = {link: base * place for link, place in zip(robot.links, placed, strict=True)}
        return touch_map({robot.subtrees[i].name: one for i, one in self._fits.items()}, places)

    def _filter(self, limb: int) -> PlaceFilter:
        """Return the filter of the touch of a limb, a new one when the touch begins."""
        if limb not in self._filters:
            self._filters[limb] = PlaceFilter(self._localiser.links_of(limb))
        return self._filters[limb]


def _together(found: list[Localisation]) -> Localisation:
    """Put the touches of several limbs into one list."""
    if len(found) < 2:
        return found[0] if found else NOWHERE
    hypotheses: list[Hypothesis] = [h for one in found for h in one.hypotheses]
    hypotheses.sort(key=lambda h: -h.probability)
    known = float(np.prod([1.0 - one.none_probability for one in found]))
    return Localisation(tuple(hypotheses), 1.0 - known)
