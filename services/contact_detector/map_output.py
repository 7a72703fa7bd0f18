"""The port on which the map of the touches goes out while somebody reads it."""

from bus import Node
from bus.envelope import Envelope
from estimation.contact.touch_map import NO_MAP, TouchMap
from robot_model import Robot, ports
from robot_model.messages import ContactMap


class MapOutput:
    """Writes a map at the rate at which places are looked for, empty while nothing touches."""

    def __init__(self, node: Node, robot: Robot, rate: float):
        name = ports.name("contact_map", robot)
        self._port = node.output(name, ContactMap, rate=rate, model=robot.model_hash)
        self._period = round(1e9 / rate)  # ns
        self._next = 0  # stamp

    def restart(self) -> None:
        """The stamps jumped back."""
        self._next = 0

    def wanted(self, stamp: int) -> bool:
        """Whether anybody reads a map of this stamp [ns]."""
        return self._port.wanted(stamp)

    def publish(self, places: TouchMap, like: Envelope, doubt: str) -> None:
        """Write what was found last, or that nothing is known and why."""
        if like.stamp < self._next or not self._port.wanted(like.stamp, not doubt):
            return
        self._next = like.stamp + self._period
        self._port.write(
            _message(NO_MAP if doubt else places), like=like, valid=not doubt, reason=doubt
        )

    def complain(self, like: Envelope | None, reason: str) -> None:
        """Say that no frames come."""
        if self._port.heard:
            self._port.write(_message(NO_MAP), like=like, valid=False, reason=reason)


def _message(places: TouchMap) -> ContactMap:
    return ContactMap(**vars(places))
