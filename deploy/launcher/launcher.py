"""Starts an application's services on this host, keeps them up, stops them all."""

import signal
import threading
import time
from collections.abc import Callable
from typing import Any

from bus import Node, runtime_directory
from bus.rpc_server import Pending
from bus.session import check_local
from deploy.errors import UsageError
from deploy.launcher.application import Application
from deploy.launcher.commands import Commands, params_of
from deploy.launcher.endpoints import free_port, with_free_port
from deploy.launcher.hub import await_hub, await_start
from deploy.launcher.logs import Log
from deploy.launcher.others import OtherHosts, launcher_name
from deploy.launcher.parts import Service
from deploy.launcher.process import Process, stop_all
from deploy.launcher.requests import Requests

GRACE = 2.5  # [s] before SIGKILL; with the hub after them, all ends within five
TICK = 0.05  # [s]


class Launcher:
    """An application on one host.

    Args:
        application: What to run.
        namespace: Key prefix on the bus that sets this run apart from others.
        host: Which of the application's services are ours.
        on_ready: Called once, when every service of this host is ready for the first time.
        insecure: Allow links to other machines, which nothing protects.
        check: Called while the hub starts, before any service does; it may refuse.

    Raises:
        BusError: The application has such links, and they are not allowed.
    """

    def __init__(
        self,
        application: Application,
        namespace: str,
        host: str = "localhost",
        on_ready: Callable[["Launcher"], None] = lambda launcher: None,
        insecure: bool = False,
        check: Callable[[], None] = lambda: None,
    ):
        self.application = application
        self.namespace = namespace
        self.endpoint = with_free_port(application.hub.endpoint)
        self.dashboard_url = ""
        self._host, self._insecure = host, insecure
        self._listen = application.listen(host)
        check_local([self.endpoint, self._listen], insecure)
        self._name = launcher_name(application, host)
        self._has_hub = application.hub.host == host
        services = application.services_of(host)
        self.log = Log(["hub", "launcher", *services])
        lasting = application.hub.namespace is not None
        self._commands = Commands(self.endpoint, namespace, self._listen, insecure, lasting)
        self.services = [self._process(name, spec) for name, spec in services.items()]
        self.hub = Process("hub", self._commands.hub(), self.log)
        self._on_ready, self._check = on_ready, check
        self._was_ready = self._was_whole = False
        self._lacking: dict[str, list[str]] = {}
        self._stopping = self._ends_all = False

    @property
    def processes(self) -> list[Process]:
        """Everything that is started here, the hub first."""
        return [self.hub, *self.services] if self._has_hub else self.services

    def run(self, seconds: float | None = None) -> None:
        """Run until a signal, ``down``, the end of ``seconds`` [s] or of who reads our log.

        Raises:
            UsageError: A service refused its settings before the application was ready, or
                what ``check`` says.
            CommandError: The hub did not start.
        """
        end = None if seconds is None else time.monotonic() + seconds
        try:
            self._start_hub()
            self._take_signals()
            if self._has_hub:
                await_start(self.hub, self.endpoint, lambda: self._stopping)
            elif not await_hub(self.application.hub, self.log, lambda: self._ends(end)):
                return
            for process in self.services:
                process.start()
            with self._open() as node:
                self._run(node, end)
        finally:
            stop_all(self.services, GRACE)
            stop_all([self.hub], 1.0)

    def _open(self) -> Node:
        return Node(
            self._name,
            connect=self.endpoint,
            listen=self._listen,
            namespace=self.namespace,
            insecure=self._insecure,
        )

    def status(self) -> list[dict[str, Any]]:
        """Return one entry per service of this host, as ``wrenchbus status --json`` prints them."""
        return [{**process.status(), "host": self._host} for process in self.processes]

    def _start_hub(self) -> None:
        """Check while the hub starts; where that refuses, nobody has joined it: it is killed."""
        if self._has_hub:
            self.hub.start()
        try:
            self._check()
        except BaseException:
            self.hub.send(signal.SIGKILL)
            raise

    def _take_signals(self) -> None:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, self._stop)

    def _stop(self, *_: Any) -> None:
        self._stopping = True

    def _ends(self, end: float | None) -> bool:
        late = end is not None and time.monotonic() >= end
        return late or self._stopping or self.log.closed

    def _run(self, node: Node, end: float | None) -> None:
        others = OtherHosts(node, self.application, self._host)
        node.rpc(f"/{self._name}/rpc:i", {"status": lambda: self._tell(others)})
        where = "all hosts" if self._has_hub else "this host"
        node.verb("down", lambda: self._down(others), f"end the application, on {where}")
        node.ready()
        requests = Requests(node, self.application.once_ready, self.log)
        entry = self._announce()
        try:
            while node.running and not self._ends(end):
                node.wait(TICK)
                self._look_after(node, others, requests)
        finally:
            requests.cancel()
            stop_all(self.services, GRACE)  # while the bus stands, they leave it in order
            if self._ends_all:
                others.await_end(GRACE)
            requests.join()
            runtime_directory.remove(entry)

    def _tell(self, others: OtherHosts) -> Any:
        """Answer with the status of all hosts, where others must be asked without our waiting."""
        own = self.status()
        if not others:
            return own
        pending = Pending()
        threading.Thread(target=lambda: pending.reply(own + others.status())).start()
        return pending

    def _down(self, others: OtherHosts) -> dict[str, Any]:
        """End here, and on the hub's host everywhere."""
        silent = others.end()
        hint = f"; no answer from {', '.join(silent)}, end them there" if silent else ""
        self.log.say("launcher", f"asked to end{hint}")
        self._stopping = self._ends_all = True
        return {"host": self._host, "no_answer": silent}

    def _announce(self):
        return runtime_directory.announce(
            self.endpoint, self.namespace, self.dashboard_url, self._insecure
        )

    def _look_after(self, node: Node, others: OtherHosts, requests: Requests) -> None:
        for process in self.processes:
            process.supervise()
        ready = {(owner.service, owner.pid) for owner in node.directory.services()}
        for process in self.processes:
            if process.state == "starting" and (process.name, process.pid) in ready:
                process.state = "ready"
        if not self._was_ready:
            self._wait_for_ours()
        elif self._has_hub and not self._was_whole:
            self._wait_for_others(others, requests)

    def _wait_for_ours(self) -> None:
        states = {process.name: process.state for process in self.processes}
        if "failed" in states.values():
            names = ", ".join(name for name, state in states.items() if state == "failed")
            raise UsageError(f"{names} refused its settings; see its message above")
        if set(states.values()) == {"ready"}:
            self._was_ready = True
            self._on_ready(self)

    def _wait_for_others(self, others: OtherHosts, requests: Requests) -> None:
        lacking = others.not_ready()
        if not lacking:
            self._was_whole = True
            if others:
                self.log.say("launcher", "all services of all hosts are ready")
            requests.start()
        elif lacking != self._lacking:
            listed = "; ".join(f"{', '.join(names)} of {host}" for host, names in lacking.items())
            self.log.say("launcher", f"waits for {listed}")
        self._lacking = lacking

    def _process(self, name: str, spec: Service) -> Process:
        params = params_of(self.application, name)
        if spec.page_port:
            port = params.get(spec.page_port) or free_port()
            params[spec.page_port] = port
            self.dashboard_url = f"http://127.0.0.1:{port}"
        priority = "realtime" if spec.realtime else str(spec.nice)
        command = self._commands.service(name, spec, params)
        return Process(name, command, self.log, priority, spec.restart)
