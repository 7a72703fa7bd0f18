"""Machines in a room: network namespaces on one switch, whose cables can be pulled."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[2]
STOP_WITHIN = 10.0  # s
# the host's name is a namespace of its own
NAMED = ["unshare", "--uts", "sh", "-c", 'hostname "$0" && exec "$@"']


def why_not() -> str:
    """Return why this machine allows no network namespaces; empty when it does."""
    if os.geteuid() != 0:
        return "network namespaces need root"
    if not (shutil.which("ip") and shutil.which("unshare")):
        return "network namespaces need the commands ip (package iproute2) and unshare"
    name = f"wb{os.getpid()}-try"
    tried = subprocess.run(["ip", "netns", "add", name], capture_output=True, text=True)
    if tried.returncode:
        return f"ip netns add: {tried.stderr.strip()}"
    ip("netns", "del", name)
    return ""


def ip(*arguments: str) -> None:
    """Run ``ip``."""
    subprocess.run(["ip", *arguments], check=True)


class HostProcess:
    """A Python module that runs on a host."""

    def __init__(self, prefix: Sequence[str], arguments: Sequence[str], runtime: Path):
        self._log = tempfile.TemporaryFile()
        self.popen = subprocess.Popen(
            [*prefix, sys.executable, "-m", *arguments],
            stdout=self._log,
            stderr=self._log,
            stdin=subprocess.DEVNULL,
            cwd=ROOT,
            start_new_session=True,
            env={**os.environ, "XDG_RUNTIME_DIR": str(runtime), "OMP_NUM_THREADS": "1"},
        )

    @property
    def output(self) -> str:
        """All that it has written so far."""
        self._log.seek(0)
        return self._log.read().decode(errors="replace")

    def end(self) -> int:
        """End it; return its exit status."""
        if self.popen.poll() is None:
            self.popen.send_signal(signal.SIGTERM)
        try:
            return self.popen.wait(STOP_WITHIN)
        except subprocess.TimeoutExpired:
            os.killpg(self.popen.pid, signal.SIGKILL)
            return self.popen.wait()

    def close(self) -> None:
        """Forget what it has written."""
        self._log.close()


class Host:
    """One machine: addresses, processes and a runtime directory of its own."""

    def __init__(self, name: str, number: int, prefix: str, folder: Path):
        self.name, self.address = name, f"10.0.0.{number}"
        self._space, self._switch = f"{prefix}-{name}", f"{prefix}-switch"
        self._runtime = folder / name
        self._runtime.mkdir()
        self._processes: list[HostProcess] = []
        ip("netns", "add", self._space)
        ends = ("type", "veth", "peer", "name", name, "netns", self._switch)
        ip("link", "add", "eth0", "netns", self._space, *ends)
        ip("-n", self._switch, "link", "set", name, "master", "br0", "up")
        ip("-n", self._space, "addr", "add", f"{self.address}/24", "dev", "eth0")
        for device in ("lo", "eth0"):
            ip("-n", self._space, "link", "set", device, "up")

    def start(self, *arguments: str) -> HostProcess:
        """Run ``python -m arguments`` there."""
        prefix = ["ip", "netns", "exec", self._space, *NAMED, self.name]
        self._processes.append(HostProcess(prefix, arguments, self._runtime))
        return self._processes[-1]

    def run(self, *arguments: str, timeout: float = 60.0) -> str:
        """Run ``python -m arguments`` there to its end; return what it wrote."""
        process = self.start(*arguments)
        status = process.popen.wait(timeout)
        assert status == 0, f"{arguments} ended with {status} on {self.name}:\n{process.output}"
        return process.output

    @contextmanager
    def without_cable(self, at_switch: bool) -> Iterator[float]:
        """Cut the host off, at the switch or at its own end; yield when [s, monotonic]."""
        self._set("down", at_switch)
        try:
            yield time.monotonic()
        finally:
            self._set("up", at_switch)

    @contextmanager
    def without(self, other: "Host") -> Iterator[float]:
        """Let nothing reach one other host; yield since when [s, monotonic]."""
        route = ("blackhole", f"{other.address}/32")
        ip("-n", self._space, "route", "add", *route)
        try:
            yield time.monotonic()
        finally:
            ip("-n", self._space, "route", "del", *route)

    def _set(self, state: str, at_switch: bool) -> None:
        space, device = (self._switch, self.name) if at_switch else (self._space, "eth0")
        ip("-n", space, "link", "set", device, state)

    def close(self) -> None:
        """End all that runs there, and the host."""
        for process in reversed(self._processes):
            process.end()
            process.close()
        ip("netns", "del", self._space)


@contextmanager
def network(names: Sequence[str], folder: Path) -> Iterator[dict[str, Host]]:
    """Put hosts on a switch; at the end nothing is left of them."""
    prefix = f"wb{os.getpid()}"
    hosts: dict[str, Host] = {}
    ip("netns", "add", f"{prefix}-switch")
    try:
        ip("-n", f"{prefix}-switch", "link", "add", "br0", "type", "bridge")
        ip("-n", f"{prefix}-switch", "link", "set", "br0", "up")
        for number, name in enumerate(names, 1):
            hosts[name] = Host(name, number, prefix, folder)
        yield hosts
    finally:
        for host in reversed(hosts.values()):
            host.close()
        ip("netns", "del", f"{prefix}-switch")
