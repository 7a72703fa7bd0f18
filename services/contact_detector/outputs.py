"""What the contact detector writes."""

from typing import Any

from bus import Node
from bus.envelope import Envelope
from estimation.contact.contact_detector import ContactDetector
from estimation.contact.limb_monitor import LimbFlag
from estimation.contact.localisation import NOWHERE, Localisation
from estimation.contact.touch_points import TouchPoints
from estimation.residual.residual_bank import ResidualBank
from robot_model import Robot, ports
from robot_model.messages import ContactPoints, Contacts, Residuals
from services.contact_detector.config import ContactDetectorConfig
from services.contact_detector.map_output import MapOutput
from services.contact_detector.messages import contacts_message, points_message
from services.contact_detector.place_search import Found


class Outputs:
    """The ports of residuals, contacts, their map, and the places told to the observer.

    Nothing is encoded that nobody reads. A ``doubt`` is the reason for which nothing is
    known of contacts, empty when something is.
    """

    def __init__(self, node: Node, robot: Robot, config: ContactDetectorConfig):
        model: dict[str, Any] = {"model": robot.model_hash}
        common = {**model, "dimensions": robot.dimensions}
        rate, locate_rate = config.rate, config.locate_rate
        self._residuals = node.output(
            ports.name("residuals", robot), Residuals, rate=rate, **common
        )
        self._contacts = node.output(ports.name("contacts", robot), Contacts, rate=rate, **model)
        self._map = MapOutput(node, robot, locate_rate)
        self._points = node.output(
            ports.name("touch_points", robot), ContactPoints, rate=locate_rate
        )
        self._places, self._next_places = TouchPoints(robot), 0  # stamp, ns

    def restart(self) -> None:
        """The stamps jumped back."""
        self._next_places = 0
        self._map.restart()

    def wants_residuals(self, stamp: int) -> bool:
        """Whether anybody reads the residuals of a stamp."""
        return self._residuals.wanted(stamp)

    def wants_map(self, stamp: int) -> bool:
        """Whether anybody reads the map of the places."""
        return self._map.wanted(stamp)

    def residuals(self, bank: ResidualBank, like: Envelope) -> None:
        """Write the residuals of the last sample."""
        if self._residuals.wanted(like.stamp, bank.valid):
            self._residuals.write(bank.message(), like=like, valid=bank.valid, reason=bank.reason)

    def contacts(
        self,
        detector: ContactDetector,
        flags: list[LimbFlag],
        found: Found,
        like: Envelope,
        doubt: str,
    ) -> None:
        """Write flags, hypotheses and the map of the places."""
        self._map.publish(found.places, like, doubt)
        if not self._contacts.wanted(like.stamp, not doubt):
            return
        if doubt:
            message = _nothing(detector, doubt)
        else:
            message = contacts_message(flags, found.located, detector.body)
        self._contacts.write(message, like=like, valid=not doubt, reason=doubt)

    def places(
        self, touched: list[int], located: Localisation, period: int, like: Envelope, doubt: str
    ) -> None:
        """Tell where forces act once per period [ns].

        Whether or not that is new: who has just come needs it too.
        """
        if like.stamp < self._next_places:
            return
        self._next_places = like.stamp + period
        places = self._places.update([] if doubt else touched, located)
        self._points.write(points_message(places), like=like, valid=not doubt, reason=doubt)

    def complain(
        self, detector: ContactDetector, bank: ResidualBank, tells: bool, like: Any, reason: str
    ) -> None:
        """Say that nothing is known, with the last envelope if there is one."""
        said: dict[str, Any] = {"like": like, "valid": False, "reason": reason}
        self._residuals.write(bank.silent_message(), **said)
        self._contacts.write(_nothing(detector, reason), **said)
        self._map.complain(like, reason)
        if tells:
            self._points.write(points_message([]), **said)


def _nothing(detector: ContactDetector, reason: str) -> Contacts:
    limbs = detector.monitor.limbs
    flags = [LimbFlag(limb, "none", 0.0, 0, 0.0, False, reason) for limb in limbs]
    return contacts_message(flags, NOWHERE)
