"""How probable a touch is at each place of the surface, and the line it acts along."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from estimation.contact.link_fits import LinkFits
from estimation.contact.localisation import link_probabilities

Array = np.ndarray
FAINT = 1e-4  # probability of a link below which its places are left out
BEHIND = 40.0  # log-probability behind the best that is as good as none
MOST = 1500  # places of all touches; the likeliest are kept


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
    spread = _likeliest([part for one in fits.values() for part in _over_links(one)])
    lines = [_line(one, places) for one in fits.values()]
    return TouchMap(
        link=[part.link for part in spread],
        count=[len(part.point) for part in spread],
        point=np.concatenate([_NONE, *(part.point for part in spread)]),
        probability=np.concatenate([_NONE[:, 0], *(part.probability for part in spread)]),
        limb=list(fits),
        line_point=np.array([point for point, _ in lines]),
        line_direction=np.array([direction for _, direction in lines]),
    )


class _Spread(NamedTuple):
    """How a touch is spread over one link."""

    link: str
    point: Array  # (p, 3)
    probability: Array  # (p,)


def _over_links(fits: LinkFits) -> list[_Spread]:
    """Return the places of every link that is not out of the question."""
    tried = fits.places()
    probability, _ = link_probabilities(fits)
    weights = dict(zip(tried.links, tried.split(tried.weight), strict=True))
    points = dict(zip(tried.links, tried.split(tried.point), strict=True))
    parts = []
    for link, mine in zip(fits.links, probability.tolist(), strict=True):
        if mine > FAINT and link in weights:
            share = np.exp(np.maximum(weights[link] - weights[link].max(), -BEHIND))
            parts.append(_Spread(link, points[link], mine * share / share.sum()))
    return parts


def _likeliest(parts: list[_Spread]) -> list[_Spread]:
    """Keep no more places than a message bears."""
    if sum(len(part.point) for part in parts) <= MOST:
        return parts
    every = np.concatenate([part.probability for part in parts])
    kept = np.zeros(len(every), dtype=bool)
    kept[np.argpartition(every, -MOST)[-MOST:]] = True
    ends = np.cumsum([len(part.point) for part in parts])
    pairs = zip(parts, np.split(kept, ends[:-1]), strict=True)
    return [_Spread(x.link, x.point[k], x.probability[k]) for x, k in pairs if k.any()]


def _line(fits: LinkFits, places: Mapping[str, pin.SE3]) -> tuple[Array, Array]:
    """Return the point of the best touch and the direction of its force, in the base's frame."""
    best = int(fits.weight.argmax())
    place, force = places[fits.links[best]], fits.force[best]
    return place.act(fits.point[best]), place.rotation @ force / np.linalg.norm(force)
