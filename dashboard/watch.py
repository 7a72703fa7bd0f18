"""Looks at the ports and at the emergency stop now and then, beside the page's loop."""

import threading
import time
from collections.abc import Callable
from typing import Any

from bus import BusError, Node
from bus.introspection import list_ports, port_info
from robot_model import ports

from .input_rows import InputRow, input_rows
from .port_rows import PortRow, Written, port_rows

ANSWER = 0.5  # [s]


class Watch:
    """A thread that renews its attributes while somebody looks at the page."""

    def __init__(self, node: Node, period: float, watched: Callable[[], bool]):
        self.outputs: list[PortRow] = []
        self.inputs: list[InputRow] = []
        self.holding = False
        self.recorder: dict[str, Any] = {}  # its status; empty where there is none
        self.observer: dict[str, Any] = {}  # likewise
        self._node, self._period, self._watched = node, period, watched
        self._written = Written()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="watch ports")
        self._thread.start()

    def close(self) -> None:
        """Look no more."""
        self._closing.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._closing.wait(self._period):
            if self._watched():
                ports = self._look()
                self.outputs = port_rows(ports, self._written, time.monotonic())
                self.inputs = input_rows(ports)
                self.holding = self._ask_holding()
                self.recorder = self._ask_status("recorder", self.recorder)
                self.observer = self._ask_status("torque_observer", self.observer)

    def _look(self) -> list[dict[str, Any]]:
        silent: set[tuple[str, int]] = (
            set()
        )  # processes that did not answer: asked once, not once per port
        told = []
        for entry in list_ports(self._node):
            process = entry["owner"]["host"], entry["owner"]["pid"]
            if self._closing.is_set() or entry["direction"] == "rpc":
                continue
            told.append({**entry, "error": "no answer"} if process in silent else self._ask(entry))
            if "error" in told[-1]:
                silent.add(process)
        return told

    def _ask(self, entry: dict) -> dict:
        try:
            return port_info(self._node, entry["name"], ANSWER)
        except BusError as error:  # closed since it was listed
            return {**entry, "error": str(error)}

    def _ask_holding(self) -> bool:
        try:
            status = self._node.call(ports.rpc("sensor_server"), "status", timeout=ANSWER)
        except BusError:
            return self.holding
        return bool(status.get("holding", False))

    def _ask_status(self, service: str, known: dict[str, Any]) -> dict[str, Any]:
        port = ports.rpc(service)
        if self._node.directory.leader(port) is None:
            return {}
        try:
            return self._node.call(port, "status", timeout=ANSWER)
        except BusError:
            return known
