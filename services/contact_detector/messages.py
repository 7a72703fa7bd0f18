"""What the contact detector says, as messages."""

from typing import Any

from estimation.limb_monitor import LimbFlag
from estimation.localisation import Hypothesis, Localisation
from robot_model.messages import Contacts


def contacts_message(flags: list[LimbFlag], located: Localisation) -> Contacts:
    """Return the message of flags and hypotheses."""
    return Contacts(
        flags=[_flag(flag) for flag in flags],
        hypotheses=[_hypothesis(one) for one in located.hypotheses],
        none_probability=located.none_probability,
    )


def _flag(flag: LimbFlag) -> dict[str, Any]:
    return {
        "limb": flag.limb,
        "state": flag.state,
        "probability": flag.probability,
        "onset": flag.onset,
        "force": flag.force,
        "valid": flag.valid,
        "reason": flag.reason,
    }


def _hypothesis(one: Hypothesis) -> dict[str, Any]:
    return {
        "links": list(one.links),
        "point": one.point.tolist(),
        "force": one.force.tolist(),
        "covariance": one.covariance.tolist(),
        "probability": one.probability,
    }
