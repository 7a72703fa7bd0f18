"""What the contact detector says, as messages."""

from functools import lru_cache
from typing import Any

from estimation.contact.limb_monitor import LimbFlag
from estimation.contact.localisation import Localisation
from robot_model.messages import Contacts


def contacts_message(flags: list[LimbFlag], located: Localisation) -> Contacts:
    """Return the message of flags and hypotheses."""
    return Contacts(
        flags=[flag._asdict() for flag in flags],
        hypotheses=_hypotheses(located),
        none_probability=located.none_probability,
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
