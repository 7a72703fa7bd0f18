"""What the page reads: the newest message of each port, and nothing in between."""

import time
from typing import Any

from bus import Input, Node
from robot_model import Robot, ports
from robot_model.messages import (
    BaseState,
    ContactMap,
    Contacts,
    ExternalWrenches,
    GroundTruth,
    JointTorques,
    Residuals,
    SensorFrame,
)

from .snapshot import Snapshot

PATIENCE = 0.25  # [s] shorter gaps are not shown: a page that blinks tells nobody anything

READ = {
    "sensors": SensorFrame,
    "base": BaseState,
    "torques": JointTorques,
    "wrenches": ExternalWrenches,
    "residuals": Residuals,
    "contacts": Contacts,
    "contact_map": ContactMap,
    "truth": GroundTruth,
}


class Inputs:
    """The page's inputs by name; ``sources`` replaces the source port of some."""

    def __init__(self, node: Node, robot: Robot, sources: dict[str, str]):
        unknown = sources.keys() - READ.keys()
        if unknown:
            raise LookupError(f"inputs: no {sorted(unknown)}; the page reads {sorted(READ)}")
        self._sources = {what: sources.get(what, ports.name(what, robot)) for what in READ}
        self._inputs: dict[str, Input] = {
            what: node.input(
                ports.service_input(robot, "dashboard", what),
                message,
                source=self._sources[what],
                depth=1,
                rate=ports.rate(what),
                model=robot.model_hash,
                dimensions=robot.dimensions,
                polled=True,
                stream="thinned",
            )
            for what, message in READ.items()
        }
        self._good: dict[str, Any] = {}
        self._seen: dict[str, float] = {}
        self._troubles: dict[str, str] = {}
        self._unwanted: set[str] = set()
        self._resting = False

    def read(self) -> Snapshot:
        """Take what has arrived, and return what is fresh and valid, or was a moment ago."""
        now = time.monotonic()
        for what, source in self._inputs.items():
            source.newest()
            self._troubles[what] = "not wanted" if what in self._unwanted else _trouble(source)
            if source.latest is not None and not self._troubles[what]:
                self._good[what] = source.latest.data
                self._seen[what] = now
            elif now - self._seen.get(what, -PATIENCE) >= PATIENCE:
                self._good.pop(what, None)
        return Snapshot(**self._good)

    def rest(self, resting: bool) -> None:
        """Read nothing while nobody looks, so that nobody writes for us alone."""
        self._resting = resting
        for what, source in self._inputs.items():
            source.rest(resting or what in self._unwanted)

    def want(self, what: str, wanted: bool) -> None:
        """Read one of the messages, or do without it."""
        if wanted == (what not in self._unwanted):
            return
        self._unwanted ^= {what}
        self._inputs[what].rest(self._resting or not wanted)

    def trouble(self, what: str) -> str:
        """Return why the last snapshot lacks a message; empty when it has it."""
        return "" if what in self._good else self._troubles.get(what, "not read yet")

    def ages(self) -> dict[str, float]:
        """Return the age of the newest measurement [s] by source port."""
        now = time.time_ns()
        newest = ((self._sources[what], self._inputs[what].latest) for what in READ)
        return {name: (now - last.envelope.acquired) * 1e-9 for name, last in newest if last}

    def time(self, what: str) -> float | None:
        """Return the stamp of the newest message [s], whatever its state."""
        latest = self._inputs[what].latest
        return None if latest is None else latest.envelope.stamp * 1e-9


def _trouble(source: Input) -> str:
    """Return why an input has no fresh and valid message."""
    if source.latest is None or not source.fresh:
        return source.reason
    envelope = source.latest.envelope
    return "" if envelope.valid else envelope.reason or "invalid"
