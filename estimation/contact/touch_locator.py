"""Where each touched limb is touched, as long as it is touched."""

from collections.abc import Sequence
from math import expm1

import numpy as np

from estimation.contact.contact_rows import ContactRows
from estimation.contact.link_fits import LinkFits
from estimation.contact.localisation import NOWHERE, Hypothesis, Localisation, ranked
from estimation.contact.localiser import Localiser
from estimation.contact.row_covariance import RowCovariance, RowNoise
from estimation.contact.touch_map import TouchMap, touch_map
from robot_model.messages import SensorFrame

Array = np.ndarray


class TouchLocator:
    """Smooths the rows of the touches, and finds the place of each touch from them.

    Each limb is looked at for itself: other touched limbs and those that are not
    valid are made blind.

    Attributes:
        fits: How well the links of each limb explain its touch, by sub-tree, of the last
            ``locate``.
    """

    def __init__(self, rows: ContactRows, noise: RowNoise, smoothing: float, method: str):
        self._rows = rows
        self._covariance = RowCovariance(rows, noise)
        self._localiser = Localiser(rows, method)
        self._smooth = np.zeros(rows.layout.model.nv)
        self.smoothing = smoothing  # s, time constant
        self.fits: dict[int, LinkFits] = {}
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
            del self.fits[limb]
            self._localiser.method.forget(limb)

    def add(self, touch: Array, period: float) -> None:
        """Take tared rows (nv,), ``period`` seconds after the last ones."""
        blend = 1.0 if self._fresh else -expm1(-period / self.smoothing)
        self._smooth += blend * (touch - self._smooth)
        self._fresh = False

    def locate(
        self,
        frame: SensorFrame,
        touched: Sequence[int],
        unjudged: Sequence[int],
        model_error: Array,
        stamp: int,
    ) -> Localisation:
        """Locate the touch of every touched limb, at the posture of the rows.

        Args:
            frame: Of the last rows; its flags count.
            touched: Indices of the touched sub-trees.
            unjudged: Indices of those that cannot be judged.
            model_error: Standard deviation of what the model predicts, (nv,).
            stamp: Time of the rows [ns].

        Returns:
            Probabilities of one limb sum to one with its share of none.
        """
        for limb in touched:
            self._fit(frame, limb, {*touched, *unjudged} - {limb}, model_error)
        found = [ranked(fits) for fits in self.fits.values()]
        if len(found) < 2:
            return found[0] if found else NOWHERE
        hypotheses: list[Hypothesis] = [h for one in found for h in one.hypotheses]
        hypotheses.sort(key=lambda h: -h.probability)
        nowhere = float(np.mean([one.none_probability for one in found]))
        return Localisation(tuple(hypotheses), nowhere)

    def map(self) -> TouchMap:
        """Return the places of the touches that the last ``locate`` found."""
        robot, placed = self._rows.robot, self._rows.place_links()
        base = placed[robot.links.index(robot.base_link)].inverse()
        places = {link: base * place for link, place in zip(robot.links, placed, strict=True)}
        return touch_map({robot.subtrees[i].name: one for i, one in self.fits.items()}, places)

    def _fit(self, frame: SensorFrame, limb: int, blind: set[int], model_error: Array) -> None:
        blind = blind - set(self._rows.removed.subtrees)
        removed = self._rows.removing(sorted(blind))
        touch = self._rows.remove(self._smooth.copy(), removed)
        self._covariance.update(frame, removed, model_error)
        fits = self._localiser.fit(touch, self._covariance, limb)
        if fits is not None:
            self.fits[limb] = fits
