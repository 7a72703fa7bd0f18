"""How much the ports and the processes of the bus do: differences of two looks at counters."""

import socket
import time
from collections import Counter
from typing import Any, NamedTuple

from bus import Node
from bus.introspection import port_infos
from deploy.discovery import all_ports
from deploy.usage import Usage, usage

MESSAGES = {"output": "written", "input": "received", "rpc": "answered"}
COUNTERS = ("lost", "dropped", "refused")


class Look(NamedTuple):
    """One look at everything."""

    at: float  # monotonic [s]
    ports: dict[str, dict[str, Any]]
    usages: dict[int, Usage | None]  # of the processes of this machine


class Activity:
    """What happened between the last two looks."""

    def __init__(self, node: Node):
        self._node = node
        all_ports(node)  # waits until they are known
        self._before = self._after = self._look()

    def look(self) -> None:
        """Take another look."""
        self._before, self._after = self._after, self._look()

    def ports(self) -> list[dict[str, Any]]:
        """Return one entry per port but for RPC ports that nobody asks."""
        return [row for port in self._after.ports.values() if (row := self._port(port))]

    def processes(self) -> list[dict[str, Any]]:
        """Return one entry per process, those of other machines without processor and memory."""
        owners = Counter(
            (owner["service"], owner["host"], owner["pid"])
            for owner in (port["owner"] for port in self._after.ports.values())
        )
        return [self._process(*owner, ports) for owner, ports in sorted(owners.items())]

    def _look(self) -> Look:
        names = self._node.directory.names()
        infos = {info["name"]: info for info in port_infos(self._node, names)}
        here = socket.gethostname()
        pids = {info["owner"]["pid"] for info in infos.values() if info["owner"]["host"] == here}
        return Look(time.monotonic(), infos, {pid: usage(pid) for pid in pids})

    def _port(self, port: dict[str, Any]) -> dict[str, Any] | None:
        rate = self._rate(port, MESSAGES[port["direction"]])
        if port["direction"] == "rpc" and not rate:
            return None
        statistics = port.get("statistics", {})
        row = {"port": port["name"], "direction": port["direction"], "type": port["type"]}
        row |= {"hz": rate, "bytes_per_s": self._rate(port, "bytes")}
        row |= {name: statistics.get(name) for name in COUNTERS}
        return row | {"owner": port["owner"], "error": port.get("error", "")}

    def _rate(self, port: dict[str, Any], counter: str) -> float | None:
        """Return the rate of a counter [1/s]; None where a look shows none."""
        earlier = self._before.ports.get(port["name"], {})
        before, after = (look.get("statistics", {}).get(counter) for look in (earlier, port))
        elapsed = self._after.at - self._before.at
        if before is None or after is None or after < before or elapsed <= 0.0:
            return None
        return (after - before) / elapsed

    def _process(self, service: str, host: str, pid: int, ports: int) -> dict[str, Any]:
        before, after = self._before.usages.get(pid), self._after.usages.get(pid)
        row: dict[str, Any] = {"service": service, "host": host, "pid": pid, "ports": ports}
        row |= {"cpu_percent": None, "memory_bytes": None if after is None else after.memory}
        if host == socket.gethostname() and before and after and after.at > before.at:
            row["cpu_percent"] = 100.0 * (after.cpu - before.cpu) / (after.at - before.at)
        return row
