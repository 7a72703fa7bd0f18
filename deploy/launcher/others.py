"""The launchers of an application's other hosts, asked by that of the hub's host."""

import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from bus import BusError, Node
from deploy.launcher.application import Application

TIMEOUT = 1.0  # [s] for an answer
Rows = list[dict[str, Any]]


def launcher_name(application: Application, host: str) -> str:
    """Return the name on the bus of a host's launcher."""
    return "launcher" if host == application.hub.host else f"launcher-{host}"


class OtherHosts:
    """All hosts but ours; there are none but on the hub's host."""

    def __init__(self, node: Node, application: Application, host: str):
        self._node, self._application = node, application
        asked = application.host_names - {host} if host == application.hub.host else set()
        self._hosts = sorted(asked)

    def __bool__(self) -> bool:
        return bool(self._hosts)

    def not_ready(self) -> dict[str, list[str]]:
        """Return the services that are not ready, by host; hosts of which all are, are left out."""
        ready = {owner.service for owner in self._node.directory.services()}
        lacking = {
            host: [name for name in self._application.services_of(host) if name not in ready]
            for host in self._hosts
        }
        return {host: names for host, names in lacking.items() if names}

    def status(self) -> Rows:
        """Return the entries of all their services; takes up to a second."""
        answers = self._ask_all("status")
        return [row for host in self._hosts for row in answers[host] or self._absent(host)]

    def end(self) -> list[str]:
        """Ask all to end; return the hosts that did not answer."""
        answers = self._ask_all("down")
        return [host for host in self._hosts if answers[host] is None]

    def await_end(self, timeout: float) -> None:
        """Wait until no launcher of theirs is left on the bus."""
        deadline = time.monotonic() + timeout
        while any(map(self._is_there, self._hosts)) and time.monotonic() < deadline:
            time.sleep(0.02)

    def _ask_all(self, verb: str) -> dict[str, Any]:
        with ThreadPoolExecutor(max(len(self._hosts), 1)) as pool:
            asked = {host: pool.submit(self._ask, host, verb) for host in self._hosts}
        return {host: answer.result() for host, answer in asked.items()}

    def _ask(self, host: str, verb: str) -> Any:
        if not self._is_there(host):
            return None
        try:
            return self._node.call(self._port(host), verb, timeout=TIMEOUT)
        except BusError:
            return None

    def _is_there(self, host: str) -> bool:
        return self._node.directory.leader(self._port(host)) is not None

    def _port(self, host: str) -> str:
        return f"/{launcher_name(self._application, host)}/rpc:i"

    def _absent(self, host: str) -> Rows:
        unknown = {"pid": None, "state": "absent", "ready": False, "restarts": None}
        names = self._application.services_of(host)
        return [{"service": n, **unknown, "uptime_s": None, "host": host} for n in names]
