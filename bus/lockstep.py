"""Lockstep: the plant takes its next tick when every participant has had the last one."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from bus.envelope import SIMULATED
from bus.errors import BusError, LockstepTimeout

if TYPE_CHECKING:
    from bus.node import Node


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

    @property
    def enabled(self) -> bool:
        """Whether the plant waits for this service."""
        return self._output is not None

    def acknowledge(self, stamp: int) -> None:
        """Tell the plant that a stamp [ns] is done; after its output, when one is due."""
        if self._output is not None:
            self._output.write(Acknowledgement(), stamp=stamp, clock=SIMULATED)


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
        """Wait until all participants are on the bus; raise LockstepTimeout naming the missing."""
        stands = self._node.directory.owner
        self._until(
            lambda: [s for s in self._inputs if stands(acknowledgement_port(s)) is None],
            timeout,
            "did not come to the lockstep",
        )

    def wait(self, stamp: int, timeout: float = 5.0) -> None:
        """Wait until all have acknowledged a stamp [ns]; raise LockstepTimeout naming the missing.

        Wall-time limit in seconds. RPC handlers of the node run meanwhile.
        """
        self._until(lambda: self._missing(stamp), timeout, f"did not acknowledge {stamp} ns")

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
