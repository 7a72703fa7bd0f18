"""Where each touched limb is touched, as long as it is touched."""

from collections.abc import Sequence
from math import expm1

import numpy as np

from estimation.contact.contact_rows import ContactRows
from estimation.contact.link_fits import LinkFits
from estimation.contact.localisation import NOWHERE, Hypothesis, Localisation, ranked
from estimation.contact.localiser import Localiser
from estimation.contact.place_filter import PlaceFilter
from estimation.contact.row_covariance import RowCovariance, RowNoise
from estimation.contact.touch_map import TouchMap, touch_map
from robot_model.messages import SensorFrame

Array = np.ndarray
SUDDEN = 2.0  # standard deviations of a limb's wrench from the smooth one: it changes


class TouchLocator:
    """Smooths the rows of the touches, and finds the place of each touch from them.

    Each limb is looked at for itself: other touched limbs and those that are not
    valid are made blind. What is held is known better with every look.

    Attributes:
        fits: How well the links of each limb explain its touch, by sub-tree, of the last
            ``locate``.
    """

    def __init__(self, rows: ContactRows, noise: RowNoise, smoothing: float, method: str):
        self._rows = rows
        self._covariance = RowCovariance(rows, noise)
        self._localiser = Localiser(rows, method)
        self._smooth = np.zeros(rows.layout.model.nv)
        self._posture = rows.q.copy()  # as smooth as the rows, so that it belongs to them
        self.smoothing = smoothing  # s, time constant
        self.fits: dict[int, LinkFits] = {}
        self._filters: dict[int, PlaceFilter] = {}
        self._stamp = 0  # ns, of the last look
        self.reset()

    def configure(self, smoothing: float, method: str) -> None:
        """Change the time constant [s] and the method; ValueError for an unknown one."""
        self.smoothing = smoothing
        if method != self._localiser.name:
            self.keep(())
            self._localiser.choose(method)

    def reset(self) -> None:
        """Forget all touches; the next rows are taken as they are."""
        self._smooth[:] = 0.0
        self._fresh = True
        self.keep(())

    def keep(self, touched: Sequence[int]) -> None:
        """Forget the touches of the limbs that are touched no longer."""
        for limb in [one for one in self.fits if one not in touched]:
            del self.fits[limb], self._filters[limb]
            self._localiser.method.forget(limb)

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

    def locate(
        self,
        frame: SensorFrame,
        touched: Sequence[int],
        unjudged: Sequence[int],
        model_error: Array | float,
        stamp: int,
    ) -> Localisation:
        """Locate the touch of every touched limb, at the posture of the smooth rows.

        Args:
            frame: Of the last rows; its flags count.
            touched: Indices of the touched sub-trees.
            unjudged: Indices of those that cannot be judged.
            model_error: Standard deviation of what the model predicts, (nv,).
            stamp: Time of the rows [ns].

        Returns:
            Probabilities of one limb sum to one with its share of none. ``none_probability`` is
            that the touch of at least one limb is on none of its links.
        """
        period, self._stamp = (stamp - self._stamp) * 1e-9, stamp
        with self._rows.at(self._posture):
            for limb in touched:
                fits = self._fit(frame, limb, {*touched, *unjudged} - {limb}, model_error)
                if fits is not None:
                    self.fits[limb] = self._filter(limb).add(fits, period)
        found = [ranked(fits) for fits in self.fits.values()]
        if len(found) < 2:
            return found[0] if found else NOWHERE
        hypotheses: list[Hypothesis] = [h for one in found for h in one.hypotheses]
        hypotheses.sort(key=lambda h: -h.probability)
        known = float(np.prod([1.0 - one.none_probability for one in found]))
        return Localisation(tuple(hypotheses), 1.0 - known)

    def map(self) -> TouchMap:
        """Return the places of the touches that the last ``locate`` found."""
        robot, placed = self._rows.robot, self._rows.place_links()
        base = placed[robot.links.index(robot.base_link)].inverse()
        places = {link: base * place for link, place in zip(robot.links, placed, strict=True)}
        return touch_map({robot.subtrees[i].name: one for i, one in self.fits.items()}, places)

    def _fit(
        self, frame: SensorFrame, limb: int, blind: set[int], model_error: Array | float
    ) -> LinkFits | None:
        removed = self._rows.removing(sorted(blind - set(self._rows.removed.subtrees)))
        touch = self._rows.remove(self._smooth.copy(), removed)
        self._covariance.update(frame, removed, model_error)
        return self._localiser.fit(touch, self._covariance, limb)

    def _filter(self, limb: int) -> PlaceFilter:
        """Return the filter of the touch of a limb, a new one when the touch begins."""
        if limb not in self._filters:
            self._filters[limb] = PlaceFilter(self._localiser.links_of(limb))
        return self._filters[limb]
