"""Lockstep: the plant takes its next tick when every participant has had the last one."""

import logging
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from bus.envelope import SIMULATED
from bus.errors import BusError, LockstepTimeout

if TYPE_CHECKING:
    from bus.input import Input
    from bus.node import Node

logger = logging.getLogger(__name__)

PATIENCE = 2.0  # s


@dataclass(frozen=True)
class Acknowledgement:
    """The sender has handled everything up to the envelope's stamp."""

    TYPE: ClassVar[str] = "Acknowledgement/1"


def acknowledgement_port(service: str) -> str:
    """Return the port on which a service acknowledges."""
    return f"/{service}/acknowledged:o"


class Participant:
    """A service's side: acknowledges stamps when lockstep is on, does nothing otherwise."""

    def __init__(self, node: "Node", enabled: bool):
        port = acknowledgement_port(node.name)
        self._output = node.output(port, Acknowledgement) if enabled else None
        self._done = 0

    @property
    def enabled(self) -> bool:
        """Whether the plant waits for this service."""
        return self._output is not None

    def now(self) -> tuple[int, int]:
        """Return the last stamp that is done [ns], 0 before the first, and its clock.

        The clock may be a tick ahead of the data, which then are on their way.
        """
        return self._done, SIMULATED

    def acknowledge(self, stamp: int) -> None:
        """Tell the plant that a stamp [ns] is done; after its output, when one is due."""
        if self._output is not None:
            self._done = stamp
            self._output.write(Acknowledgement(), stamp=stamp, clock=SIMULATED)


class Join:
    """Joins streams by stamp: in lockstep waits for what the other writers make of a stamp.

    Which of their messages has arrived when ours is handled is chance otherwise. Outside
    of a lockstep nothing waits: the newest message counts.
    """

    def __init__(self, node: "Node", inputs: Sequence["Input"]):
        self._node, self._inputs = node, inputs
        self._missed: set[Input] = set()  # said once

    def wait(self, stamp: int) -> None:
        """Read each input until its message for a stamp [ns] has come; at most 2 s.

        A stream of N Hz has a message for the first stamp of each 1/N s. What is stamped 0
        was said before the first tick.
        """
        for port in self._inputs:
            port.newest()
            if self._node.lockstep.enabled:
                self._await(port, stamp)

    def _await(self, port: "Input", stamp: int) -> None:
        deadline = time.monotonic() + (0.0 if port in self._missed else PATIENCE)
        while not self._has(port, stamp):
            if time.monotonic() >= deadline or not self._node.running:
                self._miss(port, stamp)
                return
            self._node.wait(0.05)
            port.newest()
        self._missed.discard(port)

    def _has(self, port: "Input", stamp: int) -> bool:
        owners = [owner for s in port.sources if (owner := self._node.directory.owner(s))]
        if not owners:
            return True  # there is nothing to wait for
        rate = max(owner.rate for owner in owners)
        period = int(1e9 / rate) if rate else 0
        due = max(stamp // period * period if period else 0, 1)
        return port.latest is not None and due <= port.latest.envelope.stamp <= stamp

    def _miss(self, port: "Input", stamp: int) -> None:
        if port not in self._missed and self._node.running:
            self._missed.add(port)
            logger.warning(
                "%s: nothing for %d ns within %g s; is its writer in the lockstep?",
                *(port.name, stamp, PATIENCE),
            )


class Lockstep:
    """The plant's side: waits for the named services."""

    def __init__(self, node: "Node", services: Sequence[str]):
        self._node = node
        self._stamps: dict[str, int | None] = {service: None for service in services}
        self._inputs = {
            service: node.input(
                f"/{node.name}/lockstep_{service}:i",
                Acknowledgement,
                source=acknowledgement_port(service),
                depth=64,
            )
            for service in services
        }

    def join(self, timeout: float = 10.0) -> None:
        """Wait until all participants are ready, and so hear the first stamp.

        Raises LockstepTimeout naming the missing.
        """
        self._until(self._absent, timeout, "did not come to the lockstep")

    def wait(self, stamp: int, timeout: float = 5.0) -> None:
        """Wait until all have acknowledged a stamp [ns]; raise LockstepTimeout naming the missing.

        Wall-time limit in seconds. RPC handlers of the node run meanwhile.
        """
        self._until(lambda: self._missing(stamp), timeout, f"did not acknowledge {stamp} ns")

    def _absent(self) -> list[str]:
        ready = {owner.service for owner in self._node.directory.services()}
        return [service for service in self._inputs if service not in ready]

    def _missing(self, stamp: int) -> list[str]:
        for service, port in self._inputs.items():
            while (received := port.read()) is not None:
                self._stamps[service] = received.envelope.stamp
        return [service for service, last in self._stamps.items() if last != stamp]

    def _until(self, missing, timeout: float, complaint: str) -> None:
        deadline = time.monotonic() + timeout
        while names := missing():
            if time.monotonic() >= deadline:
                raise LockstepTimeout(f"{', '.join(names)} {complaint} within {timeout:g} s")
            if not self._node.running:
                raise BusError("asked to end while waiting for the lockstep")
            self._node.wait(0.05)
