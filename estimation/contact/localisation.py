"""From the fits of a touch to a ranked list of where it may be."""

from dataclasses import dataclass

import numpy as np

from estimation.contact.link_fits import LinkFits

Array = np.ndarray
ALIKE = 3.0  # difference of log-probability (odds of 20) that the data do not decide
# log-odds of one push against a wrench that no point explains (two pushes, a twist, a wrong
# model): one touch in twenty, times the chance of 1/50 that such a wrench comes as near to
# the surface as a push does by its noise
NOWHERE_COST = 7.0


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One place where the robot may be touched.

    ``links``: the link itself, then those that explain the data as well; the rest is in
    the frame of the first link: point [m], force on the robot [N], covariance of both.
    """

    links: tuple[str, ...]
    point: Array  # (3,)
    force: Array  # (3,)
    covariance: Array  # (6, 6)
    probability: float


@dataclass(frozen=True, eq=False)
class Localisation:
    """Hypotheses, best first, and the probability that a touch is on none of their links."""

    hypotheses: tuple[Hypothesis, ...]
    none_probability: float


NOWHERE = Localisation((), 1.0)


def link_probabilities(fits: LinkFits) -> tuple[Array, float]:
    """Return the probability of each link, (k,), and that of none of them."""
    weights = np.append(fits.weight, fits.misfit + fits.weight.max() - NOWHERE_COST)
    probability = np.exp(weights - weights.max())
    probability /= probability.sum()
    return probability[:-1], float(probability[-1])


def ranked(fits: LinkFits, most: int = 5) -> Localisation:
    """Return the best links with their probabilities."""
    probability, none = link_probabilities(fits)
    order = np.argsort(-fits.weight)[:most].tolist()
    hypotheses = []
    for i in order:
        alike = [j for j in order if j != i and abs(fits.weight[j] - fits.weight[i]) < ALIKE]
        hypotheses.append(
            Hypothesis(
                links=tuple(fits.links[j] for j in (i, *alike)),
                point=fits.point[i],
                force=fits.force[i],
                covariance=fits.covariance[i],
                probability=float(probability[i]),
            )
        )
    return Localisation(tuple(hypotheses), none)
