"""How probable a touch is at each place of the surface, and the line it acts along."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import accumulate, pairwise

import numpy as np
import pinocchio as pin

from estimation.contact.link_fits import LinkFits
from estimation.contact.localisation import link_probabilities

Array = np.ndarray
FAINT = 1e-4  # probability of a link below which its places are left out
BEHIND = -40.0  # log-probability that is as good as none


@dataclass(frozen=True, eq=False)
class TouchMap:
    """Places of c touches, (p,) in all, one link after the other, and their lines.

    ``point`` [m] is in the frame of its link, ``probability`` sums to one less the share of
    none over the places of a touch. Lines are in the base's axes, from its origin [m].
    """

    link: list[str]
    count: list[int]
    point: Array  # (p, 3)
    probability: Array  # (p,)
    limb: list[str]
    line_point: Array  # (c, 3)
    line_direction: Array  # (c, 3) unit vectors, along the force on the robot


_NONE = np.zeros((0, 3))
NO_MAP = TouchMap([], [], _NONE, np.zeros(0), [], _NONE, _NONE)


def touch_map(fits: Mapping[str, LinkFits], places: Mapping[str, pin.SE3]) -> TouchMap:
    """Return the map of the touches.

    Args:
        fits: Of each touched limb.
        places: Placement of every link in the base's frame.
    """
    if not fits:
        return NO_MAP
    spread = [part for one in fits.values() for part in _over_links(one)]
    lines = [_line(one, places) for one in fits.values()]
    return TouchMap(
        link=[link for link, _, _ in spread],
        count=[len(point) for _, point, _ in spread],
        point=np.concatenate([_NONE, *(point for _, point, _ in spread)]),
        probability=np.concatenate([np.zeros(0), *(share for _, _, share in spread)]),
        limb=list(fits),
        line_point=np.array([point for point, _ in lines]),
        line_direction=np.array([direction for _, direction in lines]),
    )


def _over_links(fits: LinkFits) -> list[tuple[str, Array, Array]]:
    """Return name, places and their probabilities of every link that is not out of the question."""
    tried = fits.places()
    probability, _ = link_probabilities(fits)
    ends = pairwise([0, *accumulate(tried.count)])
    parts = []
    for link, mine, (i, j) in zip(fits.links, probability.tolist(), ends, strict=True):
        if mine > FAINT:
            weight = tried.weight[i:j]
            share = np.exp(np.maximum(weight - weight.max(), BEHIND))
            parts.append((link, tried.point[i:j], mine * share / share.sum()))
    return parts


def _line(fits: LinkFits, places: Mapping[str, pin.SE3]) -> tuple[Array, Array]:
    """Return the point of the best touch and the direction of its force, in the base's frame."""
    best = int(fits.weight.argmax())
    place, force = places[fits.links[best]], fits.force[best]
    return place.act(fits.point[best]), place.rotation @ force / np.linalg.norm(force)
