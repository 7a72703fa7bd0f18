"""Who says where the robot is touched, and whether it is still there."""

from typing import Any

import numpy as np

from bus import Input, Node
from robot_model.messages import ContactPoints

NOWHERE = ContactPoints(link=[], point=np.zeros((0, 3)))
REMEMBERED = 16  # writers


class Teller:
    """Hands out contact points that are new.

    A writer that repeats itself, as the contact detector does, leaves what others have said
    since alone. What a port has told ends with it, or when it no longer knows; what was
    written by hand stays.
    """

    def __init__(self, node: Node):
        self._node = node
        self._said: dict[bytes, tuple[Any, ...]] = {}  # by source
        self._port = ""  # that told what is in force; empty when nobody's
        self._source = b""

    def news(self, points: Input) -> ContactPoints | None:
        """Return new contact points that an input brings, or None."""
        received = points.newest()
        if received is not None:
            envelope = received.envelope
            told = received.data if envelope.valid else NOWHERE
            if self._is_new(envelope.source, told):
                self._follow(points, envelope.source)
                return told
        return NOWHERE if self._has_gone() else None

    def _is_new(self, source: bytes, told: ContactPoints) -> bool:
        said = _key(told)
        if self._said.get(source) == said:
            return False
        self._said[source] = said
        if len(self._said) > REMEMBERED:
            del self._said[next(iter(self._said))]
        return True

    def _follow(self, points: Input, source: bytes) -> None:
        self._source = source
        leader = self._node.directory.leader
        self._port = next((name for name in points.sources if leader(name) == source), "")

    def _has_gone(self) -> bool:
        if not self._port or self._node.directory.leader(self._port) == self._source:
            return False
        self._port = ""
        return True


def _key(points: ContactPoints) -> tuple[Any, ...]:
    """What two messages have in common that say the same."""
    vector = b"" if points.vector is None else points.vector.tobytes()
    return (*points.link, *points.unknown, points.point.tobytes(), vector)
