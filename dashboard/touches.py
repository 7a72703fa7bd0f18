"""Contact hypotheses in the world, and the alarm line."""

from typing import Any, NamedTuple

import numpy as np

from robot_model.messages import ContactMap, Contacts

from .html import AMBER, GREEN, GREY, RED
from .placement import Placement

Array = np.ndarray

REACH = 0.5  # [m] of a line of action that is drawn, to both sides
NO_CONTACT = "no contact"


class Touch(NamedTuple):
    """One contact hypothesis."""

    link: str
    point: Array  # (3,) [m], world
    force: Array  # (3,) [N], world
    probability: float

    @property
    def label(self) -> str:
        """Name, size and probability, as the alarm line has them."""
        return describe(self.link, float(np.linalg.norm(self.force)), self.probability)


class Alarm(NamedTuple):
    """What the alarm line says, and its colour."""

    text: str
    colour: str
    probability: float = 0.0  # of a contact there

    @property
    def contact(self) -> bool:
        """Whether the robot is being touched."""
        return self.text.startswith("contact: ")


def describe(link: str, force: float, probability: float) -> str:
    """Return ``<link> <force> N p=<probability>``."""
    return f"{link} {force:.1f} N p={probability:.2f}"


def touches(contacts: Contacts, placement: Placement) -> list[Touch]:
    """Return the hypotheses, best first, in the world."""
    return [_touch(hypothesis, placement) for hypothesis in contacts.hypotheses]


def _touch(hypothesis: dict[str, Any], placement: Placement) -> Touch:
    link = hypothesis["links"][0]
    return Touch(
        link,
        placement.point(link, np.asarray(hypothesis["point"], dtype=float)),
        placement.vector(link, np.asarray(hypothesis["force"], dtype=float)),
        float(hypothesis["probability"]),
    )


def action_lines(found: ContactMap, base: str, placement: Placement) -> list[tuple[Array, Array]]:
    """Return both ends of the piece of each line of action that is drawn, world [m]."""
    points = [placement.point(base, point) for point in found.line_point]
    halves = [REACH * placement.vector(base, along) for along in found.line_direction]
    return [(point - half, point + half) for point, half in zip(points, halves, strict=True)]


def alarm(contacts: Contacts | None, reason: str, default_links: dict[str, str]) -> Alarm:
    """Return the alarm line.

    Args:
        contacts: The newest message, or None when there is no fresh and valid one.
        reason: Why there is none.
        default_links: Link named for a limb while the place of its contact is not known yet.
    """
    if contacts is None:
        return Alarm(f"contact unknown: {reason}", GREY)
    touched = raised(contacts)
    if not touched:
        return Alarm(NO_CONTACT, GREEN)
    colour = RED if any(flag["state"] == "collision" for flag in touched) else AMBER
    link, force, probability = _best(contacts, touched, default_links)
    return Alarm(f"contact: {describe(link, force, probability)}", colour, probability)


def raised(contacts: Contacts) -> list[dict[str, Any]]:
    """Return the flags of the limbs that are touched."""
    return [flag for flag in contacts.flags if flag["state"] != "none"]


def _best(
    contacts: Contacts, touched: list[dict[str, Any]], default_links: dict[str, str]
) -> tuple[str, float, float]:
    """Return link, force [N] and probability of the best hypothesis, or of the surest limb."""
    if contacts.hypotheses:
        best = contacts.hypotheses[0]
        return best["links"][0], float(np.linalg.norm(best["force"])), best["probability"]
    flag = max(touched, key=lambda flag: flag["probability"])
    limb = str(flag["limb"])
    return default_links.get(limb, limb), flag.get("force", 0.0), flag["probability"]
