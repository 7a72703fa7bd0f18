"""What the contact detector says, as messages."""

from functools import lru_cache
from typing import Any

import numpy as np

from estimation.contact.limb_monitor import LimbFlag
from estimation.contact.localisation import Localisation
from estimation.contact.touch_points import TouchPoint
from robot_model.messages import ContactPoints, Contacts


def contacts_message(
    flags: list[LimbFlag], located: Localisation, body: LimbFlag | None = None
) -> Contacts:
    """Return the message of flags and hypotheses; without ``body`` it is not judged."""
    return Contacts(
        flags=[flag._asdict() for flag in flags],
        body={} if body is None else body._asdict(),
        hypotheses=_hypotheses(located),
        none_probability=located.none_probability,
    )


def points_message(places: list[TouchPoint]) -> ContactPoints:
    """Return where pure forces act; no place leaves every contact at its default."""
    return ContactPoints(
        link=[place.link for place in places],
        point=np.array([place.point for place in places]).reshape(-1, 3),
        unknown=["force"] * len(places),
    )


@lru_cache(maxsize=1)  # places are said more often than they are searched
def _hypotheses(located: Localisation) -> list[dict[str, Any]]:
    return [
        {
            "links": list(one.links),
            "point": one.point.tolist(),
            "force": one.force.tolist(),
            "covariance": one.covariance.tolist(),
            "probability": one.probability,
        }
        for one in located.hypotheses
    ]
