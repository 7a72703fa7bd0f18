"""A filter over time for the place of one touch: sharper while held, quick when it moves."""

from math import exp

import numpy as np

from estimation.contact.link_fits import LinkFits

Array = np.ndarray
MEMORY = 0.15  # s, time constant with which old looks are forgotten
LOOKS = 1.4  # looks that a long hold is worth: errors of the model do not average out
WORST = 10.0  # log-likelihood of one look that a link can at most fall behind
SLIDING = 4.0  # square distance from the mean, in scatter from look to look, beyond noise
JUMP = 0.03  # m, beyond which the touch is elsewhere on the link,
SIGMAS = 3.0  # unless it is as uncertain as that
LEAST = 1e-8  # m^2, scatter below which nothing is noise


class PlaceFilter:
    """Joins the looks at one touch.

    Log-likelihoods of the links are summed with weights that fade with ``MEMORY``: looks
    share the model's errors, so that many are worth ``LOOKS``, and a touch that goes to
    another link is believed as soon as the new looks outweigh the old. Points, in the
    frames of their links, are averaged over the same time; one that moves on steadily, by
    more than the scatter of the looks, is followed at once. Forces are those of the last look.
    """

    def __init__(self, links: list[str]):
        """Begin with no look; ``links`` are all that the touch may be on (b)."""
        self._row = {link: i for i, link in enumerate(links)}
        self._weight = np.zeros(len(links))  # sum of the looks, 0 for the best
        self._point = np.full((len(links), 3), np.nan)  # m, mean; nan where none was seen
        self._last = self._point.copy()  # of the last look
        self._seen = np.zeros(len(links))  # looks in the mean, fading
        self._steps = np.zeros(len(links))  # m^2, half the squared steps between looks, fading sum
        self._misfit, self._sum = 0.0, 0.0

    def add(self, fits: LinkFits, period: float) -> LinkFits:
        """Join one look, ``period`` seconds after the last, and return what all say."""
        kept = exp(-period / MEMORY) if self._sum else 0.0
        rows = np.array([self._row[link] for link in fits.links])
        weight = self._add_weight(rows, fits.weight, kept)
        self._misfit = kept * self._misfit + (1.0 - kept) * fits.misfit
        variance = np.trace(fits.covariance[:, :3, :3], axis1=1, axis2=2)
        point = self._add_point(rows, fits.point, JUMP**2 + SIGMAS**2 * variance, kept)
        return fits._replace(weight=weight, point=point, misfit=self._misfit)

    def _add_weight(self, rows: Array, weight: Array, kept: float) -> Array:
        share = LOOKS * (1.0 - kept) if self._sum else 1.0
        behind = np.full(len(self._weight), -WORST)
        behind[rows] = np.maximum(weight - weight.max(), -WORST)
        self._weight = kept * self._weight + share * behind
        self._weight -= self._weight.max()
        self._sum = kept * self._sum + share
        return self._weight[rows]

    def _add_point(self, rows: Array, point: Array, jump: Array, kept: float) -> Array:
        step, away = point - self._last[rows], point - self._point[rows]
        self._last[rows] = point
        far = np.vecdot(away, away)
        begins = ~(far < jump)  # also where nothing has been seen
        looks = np.where(begins, 0.0, kept * self._seen[rows])
        steps = np.where(begins, 0.0, kept * self._steps[rows] + 0.5 * np.vecdot(step, step))
        scatter = np.maximum(steps / np.maximum(looks, 1e-12), LEAST)
        gain = np.maximum(1.0 / (looks + 1.0), 1.0 - SLIDING * scatter / np.maximum(far, LEAST))
        self._seen[rows], self._steps[rows] = looks + 1.0, steps
        mean = self._point[rows] + gain[:, None] * away
        self._point[rows] = np.where(begins[:, None], point, mean)
        return self._point[rows].copy()
