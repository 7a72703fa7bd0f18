"""Starts an application's services on this host, keeps them up, stops them all."""

import json
import signal
import time
from collections.abc import Callable
from typing import Any

from bus import Node, runtime_directory
from deploy.errors import CommandError, UsageError
from deploy.launcher.application import Application, Service
from deploy.launcher.endpoints import accepts, free_port, with_free_port
from deploy.launcher.logs import Log
from deploy.launcher.process import Process, stop_all
from deploy.launcher.requests import Requests

HUB_DEADLINE = 60.0  # [s], for a very busy machine; a hub that ends is noticed at once
GRACE = 2.5  # [s] before SIGKILL; with the hub after them, all ends within five
TICK = 0.05  # [s]


class Launcher:
    """An application on one host.

    Args:
        application: What to run.
        namespace: Key prefix on the bus that sets this run apart from others.
        host: Which of the application's services are ours.
        on_ready: Called once, when every service is ready for the first time.
    """

    def __init__(
        self,
        application: Application,
        namespace: str,
        host: str = "localhost",
        on_ready: Callable[["Launcher"], None] = lambda launcher: None,
    ):
        self.application = application
        self.namespace = namespace
        self.endpoint = with_free_port(application.hub.endpoint)
        self.dashboard_url = ""
        services = {n: s for n, s in application.services.items() if s.host == host}
        self.log = Log(["hub", "launcher", *services])
        self.services = [self._process(name, spec) for name, spec in services.items()]
        self.hub = Process("hub", self._hub_arguments(), self.log)
        self._has_hub = application.hub.host == host
        self._on_ready = on_ready
        self._was_ready = False
        self._stopping = False

    @property
    def processes(self) -> list[Process]:
        """Everything that is started here, the hub first."""
        return [self.hub, *self.services] if self._has_hub else self.services

    def run(self, seconds: float | None = None) -> None:
        """Run until SIGINT, SIGTERM, SIGHUP, the end of ``seconds`` [s] or of our readers.

        Raises:
            UsageError: A service refused its settings before the application was ready.
            CommandError: The hub did not start.
        """
        end = None if seconds is None else time.monotonic() + seconds
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, self._stop)
        try:
            if self._has_hub:
                self._start_hub()
            for process in self.services:
                process.start()
            with Node("launcher", connect=self.endpoint, namespace=self.namespace) as node:
                self._run(node, end)
        finally:
            stop_all(self.services, GRACE)
            stop_all([self.hub], 1.0)

    def status(self) -> list[dict[str, Any]]:
        """Return one entry per service, as ``wrenchbus status --json`` prints them."""
        return [process.status() for process in self.processes]

    def _stop(self, *_: Any) -> None:
        self._stopping = True

    def _start_hub(self) -> None:
        self.hub.start()
        deadline = time.monotonic() + HUB_DEADLINE
        while not accepts(self.endpoint):
            if not self.hub.alive:
                raise CommandError(f"the hub ended at once; is {self.endpoint} free?")
            if time.monotonic() > deadline or self._stopping:
                raise CommandError(f"the hub does not listen on {self.endpoint}")
            time.sleep(0.01)

    def _run(self, node: Node, end: float | None) -> None:
        node.rpc("/launcher/rpc:i", {"status": self.status})
        node.ready()
        requests = Requests(node, self.application.once_ready, self.log)
        entry = self._announce()
        try:
            while node.running and not (self._stopping or self.log.closed):
                node.wait(TICK)
                self._look_after(node, requests)
                if end is not None and time.monotonic() >= end:
                    break
        finally:
            requests.cancel()
            stop_all(self.services, GRACE)  # while the bus stands, they leave it in order
            requests.join()
            if entry:
                runtime_directory.remove(entry)

    def _announce(self):
        if not self._has_hub:
            return None
        return runtime_directory.announce(self.endpoint, self.namespace, self.dashboard_url)

    def _look_after(self, node: Node, requests: Requests) -> None:
        for process in self.processes:
            process.supervise()
        ready = {owner.pid for owner in node.directory.services()}
        for process in self.processes:
            if process.state == "starting" and process.pid in ready:
                process.state = "ready"
        if not self._was_ready:
            self._wait_for_all(requests)

    def _wait_for_all(self, requests: Requests) -> None:
        states = {process.name: process.state for process in self.processes}
        if "failed" in states.values():
            names = ", ".join(name for name, state in states.items() if state == "failed")
            raise UsageError(f"{names} refused its settings; see its message above")
        if set(states.values()) == {"ready"}:
            self._was_ready = True
            self._on_ready(self)
            requests.start()

    def _hub_arguments(self) -> list[str]:
        arguments = ["bus.hub", "--no-announce", "--listen", self.endpoint]
        return [*arguments, "--namespace", self.namespace]

    def _process(self, name: str, spec: Service) -> Process:
        params = {**self.application.common, **spec.params}
        if spec.page_port:
            port = params.get(spec.page_port) or free_port()
            params[spec.page_port] = port
            self.dashboard_url = f"http://127.0.0.1:{port}"
        arguments = [spec.module, "--name", name, "--connect", self.endpoint]
        arguments += ["--namespace", self.namespace]
        for key, value in params.items():
            arguments += ["--set", f"{key}={json.dumps(value)}"]
        priority = "realtime" if spec.realtime else str(spec.nice)
        return Process(name, arguments, self.log, priority, spec.restart)
