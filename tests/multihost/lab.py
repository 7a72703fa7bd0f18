"""The application on three hosts, and what witnesses say of its streams."""

import json
import time
from pathlib import Path
from typing import Any

from bus.testing import eventually
from tests.multihost.network import Host

HUB = "tcp/10.0.0.1:7512"
# slow, so that a loaded machine does not decide
FILE = """
common: {robot: icub, support: floor}
hosts:
  robot: {listen: tcp/10.0.0.1:0}
  brain: {listen: tcp/10.0.0.2:0}
  desk: {listen: tcp/10.0.0.3:0}
hub: {host: robot, endpoint: tcp/10.0.0.1:7512, namespace: lab}
services:
  robot_sim: {host: robot, module: robot_sim, params: {profile: ideal, speed: 0.2}}
  sensor_server: {host: robot, module: services.sensor_server}
  base_estimator: {host: brain, module: services.base_estimator}
  torque_observer: {host: brain, module: services.torque_observer}
  gravity_compensator: {host: brain, module: services.gravity_compensator}
  contact_detector: {host: brain, module: services.contact_detector}
  dashboard: {host: desk, module: dashboard, page_port: port}
"""
Entry = dict[str, Any]


class Witness:
    """A process on a host that writes down what it reads of a port."""

    def __init__(self, host: Host, key: str, folder: Path):
        self.host = host.name
        self._file = folder / f"{host.name}-{key}.jsonl"
        listen = f"tcp/{host.address}:0"
        module = "tests.multihost.witness"
        self.process = host.start(module, HUB, listen, "lab", key, str(self._file))

    def entries(self, since: float = 0.0) -> list[Entry]:
        """Return what was written about the time since an instant [s, monotonic]."""
        lines = self._file.read_text().split("\n")[:-1] if self._file.exists() else []
        return [entry for entry in map(json.loads, lines) if entry["at"] >= since]

    def messages(self, since: float = 0.0) -> list[Entry]:
        """Return the messages that came since an instant."""
        return [entry for entry in self.entries(since) if "stamp" in entry]

    def good(self, since: float) -> Entry | None:
        """Return the first message since an instant that is fresh and valid."""
        return next(filter(is_good, self.messages(since)), None)

    def trouble(self, since: float) -> Entry | None:
        """Return the last news since an instant, if it is that there are no data to rely on."""
        entries = self.entries(since)
        return entries[-1] if entries and not is_good(entries[-1]) else None

    def await_good(self, timeout: float = 60.0) -> None:
        """Wait until data flow."""

        def flows() -> bool:
            entries = self.entries(time.monotonic() - 1.0)
            return sum(map(is_good, entries)) > 20 and is_good(entries[-1])

        eventually(flows, timeout, f"good data; last: {self.entries()[-3:]}")


def is_good(entry: Entry) -> bool:
    """Whether there are, or come, data to rely on."""
    return entry["fresh"] and entry.get("valid", True)


class Lab:
    """The running application."""

    def __init__(self, hosts: dict[str, Host], folder: Path):
        self.hosts = hosts
        file = folder / "lab.yaml"
        file.write_text(FILE)
        command = ("deploy.main", "up", str(file), "--insecure", "--host")
        self.launchers = {n: host.start(*command, n) for n, host in reversed(hosts.items())}
        self.until("robot", "all services of all hosts are ready")
        self.desk = Witness(hosts["desk"], "torques", folder)
        self.brain = Witness(hosts["brain"], "torques", folder)

    def until(self, host: str, text: str, timeout: float = 120.0) -> None:
        """Wait until a host's launcher has written a text."""
        launcher = self.launchers[host]
        eventually(
            lambda: text in launcher.output,
            timeout,
            f"{text!r} on {host}; launchers wrote:\n{self.output()}",
        )

    def output(self) -> str:
        """Return what all launchers wrote."""
        return "\n".join(f"--- {n}:\n{launch.output}" for n, launch in self.launchers.items())

    def command(self, host: str, *arguments: str) -> str:
        """Run a verb of the command on a host; return what it wrote but for the notice."""
        lines = self.hosts[host].run("deploy.main", *arguments).splitlines()
        return "\n".join(line for line in lines if not line.startswith("insecure: "))
