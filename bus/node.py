"""A process on the bus: its session, its ports, its RPC, its clock."""

import threading
import time
import weakref
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from bus import runtime_directory
from bus.clock import Clock, SessionClock
from bus.connector import Connector
from bus.directory import Directory
from bus.errors import BusError
from bus.freshness import Freshness
from bus.information import InformationServer
from bus.input import Input
from bus.links import alone_since, expect_names, settle
from bus.lockstep import Participant
from bus.lost import Look
from bus.names import StreamKind, check_name
from bus.output import MAX_MESSAGE, Output
from bus.parameters import Parameters
from bus.port_table import CLAIM_TIMEOUT, PortTable
from bus.rpc import call
from bus.rpc_server import Handler, RpcServer
from bus.saved_settings import save_settings
from bus.session import open_session, where_to_listen
from bus.signals import stop_flag
from bus.stream import THINNED_HZ
from bus.tokens import Owner, Token
from bus.waiter import SLICE, Waiter


class Node:
    """One service's place on the bus; use it in a ``with`` statement.

    Ports may be opened before `ready` (they claim their names together) or after it
    (each claims its name at once). All but `Output.write` belongs to one thread.

    Args:
        name: The service's name, as in ``torque_observer``.
        connect: The hub's endpoint; None finds it ($WRENCHBUS_CONNECT, runtime directory).
        listen: Where other processes reach this one; None is a free port: on the loopback, or
            where a hub on another machine is joined without protection, at the address that
            faces it.
        namespace: Prefix of all keys; None takes that of the entry found.
        zenoh_config: A Zenoh JSON5 file laid under our settings (certificates, access).
        clock_port: The simulated clock to follow, as in ``/icub/clock:o``.
        lockstep: Acknowledge stamps to the plant, and never judge by wall time.
        insecure: Allow endpoints that leave this machine without protection.
        take_over: Take names from those who have them, who then end.
        signals: Let SIGTERM and SIGINT end this node (main thread only).
    """

    def __init__(
        self,
        name: str,
        connect: str | None = None,
        listen: str | None = None,
        namespace: str | None = None,
        zenoh_config: str | Path | None = None,
        clock_port: str | None = None,
        lockstep: bool = False,
        insecure: bool = False,
        take_over: bool = False,
        signals: bool = True,
        parameters: Parameters | None = None,
    ):
        check_name(f"/{name}/rpc:i")
        endpoint, found = runtime_directory.resolve(connect)
        self.name, self.endpoint = name, endpoint
        self.namespace = found if namespace is None else namespace
        self._closed = self._stopped = False
        self._closing = threading.Lock()
        self._parts: list[Any] = []
        self._waiter = Waiter()
        self._servers: list[RpcServer] = []
        self.on_ready: list[Callable[[], None]] = []
        self.on_close: list[Callable[[], None]] = []
        self.beats: list[Callable[[], None]] = []  # called at every wait
        self.parameters = parameters or Parameters()
        self.clock = SessionClock(lockstep, self.wait, lambda: self.running)
        insecure = insecure or runtime_directory.is_insecure(endpoint)
        listen = listen or where_to_listen(endpoint, insecure and zenoh_config is None)
        self.session = open_session(
            "peer", [endpoint], [listen], self.namespace, zenoh_config, insecure
        )
        self.opened_at = time.monotonic()
        _close_before_joining_threads(self)
        self._signals = signals and stop_flag.install()
        try:
            self._open(clock_port, lockstep, take_over)
        except BaseException:
            self.close()
            raise

    def _open(self, clock_port: str | None, lockstep: bool, take_over: bool) -> None:
        self.owner = Owner.this_process(self.name, str(self.session.zid()))
        self.ports = PortTable(
            *(self.session, self.owner, self.endpoint, lambda: self.running),
            *(lambda name: self.directory.owner(name), lambda: alone_since(self.session)),
            take_over,
        )
        self._parts = [self.ports]
        self.directory = Directory(self.session, self._on_port)
        expect_names(self.session, self.directory.sessions)
        information = InformationServer(self.session, self.owner.node, self.ports)
        self._parts += [self.directory, information]
        self._rpc_name = f"/{self.name}/rpc:i"
        self.rpc(self._rpc_name, {})
        self.verb("terminate", self.stop, "end this service, as SIGTERM does")
        Connector(self)
        self.lockstep = Participant(self, lockstep)
        if clock_port is not None:
            self.follow_clock(clock_port)

    def follow_clock(self, port: str) -> None:
        """Take the session's time from a clock port, as in ``/icub/clock:o``."""
        followed = self.input(f"/{self.name}/clock:i", Clock, source=port, depth=4)
        self.clock.follow(followed)

    def output(
        self,
        name: str,
        message_type: type,
        rate: float | None = None,
        model: str = "",
        dimensions: Mapping[str, int] | None = None,
        reliable: bool = False,
        max_message: int = MAX_MESSAGE,
    ) -> Output:
        """Open an output (``:o``), or a direct writer onto an input's name (``:i``).

        Args:
            rate: Nominal rate [Hz], for those who list the port.
            model: Short hash of the robot's joints, carried by every message.
            dimensions: Numbers behind the symbols of the type's shapes.
            reliable: For rare commands: wait at most 20 ms instead of dropping.
            max_message: Limit of one message [bytes].
        """
        direct = name.endswith(":i")
        check_name(name, "" if direct else "output")
        arguments = (rate or 0.0, model, dimensions, reliable, max_message, self._now)
        if direct:
            return Output(self.session, name, message_type, *arguments)
        self.ports.check_free(name)
        port = Output(self.session, name, message_type, *arguments)
        self.ports.add(port)
        return port

    def input(
        self,
        name: str,
        message_type: type,
        source: str | Sequence[str] = (),
        depth: int = 1,
        rate: float | None = None,
        model: str = "",
        dimensions: Mapping[str, int] | None = None,
        max_message: int = MAX_MESSAGE,
        wakes: bool = True,
        polled: bool = False,
        stream: StreamKind = "whole",
    ) -> Input:
        """Open an input.

        Args:
            source: Name or names of the ports that it reads; its own key is always read.
            depth: 1 keeps the newest message only, N the newest N in order.
            rate: Nominal rate of the stream [Hz], which decides when it is stale.
            model: Refuse messages that carry another hash.
            wakes: Whether a message ends `wait`; no for streams that are read along with
                another one, where every useless wake costs some 20 us.
            polled: For loops with a pace of their own, slower than the stream: messages wait
                in Zenoh until read, which costs no thread and no wake. They count as arrived
                when they are read.
            stream: What to receive of the sources: ``whole``, each message as it is written;
                ``thinned``, the first of each 4 ms of the session's clock, for readers that
                need no more than 250 Hz; ``bundled``, all, but those of 4 ms at once, for
                polled inputs that may not skip one.
        """
        waiter = self._waiter if wakes else Waiter()
        sources = [source] if isinstance(source, str) else list(source)
        for each in (check_name(name, "input"), *sources):
            check_name(each)
        self.ports.check_free(name)
        if stream == "thinned" and rate:
            rate = min(rate, THINNED_HZ)
        freshness = Freshness(
            *(sources or [name], rate or 0.0, self.clock, self._exists, self._is_here)
        )
        port = Input(
            *(self.session, name, message_type, self.directory, waiter, freshness),
            *(sources, depth, rate or 0.0, model, dimensions, max_message, polled, stream),
        )
        self.ports.add(port)
        return port

    def rpc(self, port: str, handlers: Mapping[str, Handler]) -> RpcServer:
        """Open an RPC port, or add verbs to one that is open already."""
        server = self.ports.get(port)
        if server is None:
            server = self._open_rpc(port)
        if not isinstance(server, RpcServer):
            raise BusError(f"{port} is open already, and not an RPC port")
        for verb, handler in handlers.items():
            server.add(verb, handler)
        return server

    def verb(self, verb: str, handler: Handler, help: str = "") -> None:
        """Add a verb to this service's own RPC port, ``/<service>/rpc:i``."""
        self.rpc(self._rpc_name, {}).add(verb, handler, help)

    def call(
        self,
        port: str,
        verb: str,
        arguments: dict[str, Any] | None = None,
        timeout: float = 5.0,
        returns: Any = Any,
    ) -> Any:
        """Ask an RPC port; see `bus.rpc.call`."""
        return call(self, port, verb, arguments, timeout, returns)

    def ready(self, timeout: float = CLAIM_TIMEOUT) -> None:
        """Wait until all names are ours, then tell everybody that this service is ready.

        Raises NameTaken when another process has one of them, BusError when no hub answers.
        """
        self.ports.make_ready(timeout, self._prepare)

    @property
    def running(self) -> bool:
        """False once SIGTERM or SIGINT came, or the node was stopped or closed."""
        return not (self._stopped or (self._signals and stop_flag.set))

    def stop(self) -> None:
        """Make `running` False, from any thread."""
        self._stopped = True
        self._waiter.wake()

    def wait(self, timeout: float) -> bool:
        """Wait for a message, at most ``timeout`` seconds; return whether something came.

        RPC handlers run in here. Raises NameTaken when another process took a name of ours.
        """
        came = self._waiter.wait(timeout)
        if not came and timeout > SLICE:
            came = self._wait_on(time.monotonic() + timeout - SLICE)
        for beat in self.beats:
            beat()
        if came:
            for server in self._servers:
                if server.waiting:
                    server.run()
            self.clock.poll()
        if self.ports.lost is not None:
            raise self.ports.lost
        return came

    def status(self) -> dict[str, Any]:
        """Return the state of this service."""
        inputs = [port for port in self.ports if isinstance(port, Input)]
        return {
            "service": self.name,
            "pid": self.owner.pid,
            "host": self.owner.host,
            "ready": self.ports.ready,
            "uptime_s": time.monotonic() - self.opened_at,
            "clock": self.clock.state,
            "stale": {port.name: port.reason for port in inputs if port.rate and port.reason},
        }

    def stands(self, name: str) -> bool:
        """Whether a port stands, as far as we see or the hub tells, who hears of it first."""
        return self._exists(name) or bool(Look(self.session).owners_of(name))

    def acknowledge(self, stamp: int) -> None:
        """Acknowledge a stamp [ns] to the plant; does nothing unless in lockstep."""
        self.lockstep.acknowledge(stamp)

    def close(self) -> None:
        """Leave the bus; may be called again. Everything has stopped when it returns."""
        with self._closing:
            if self._closed:
                return
            self._closed = self._stopped = True
            self._close()

    def _close(self) -> None:
        for callback in self.on_close:
            callback()
        for part in self._parts:
            part.close()
        settle(self.session, self.opened_at)
        self.session.close()
        if self._signals:
            stop_flag.uninstall()

    def __enter__(self) -> "Node":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _param(self, action: str, name: str = "", value: Any = None) -> Any:
        if action == "save":
            return save_settings(self.name, self.parameters)
        return self.parameters.handle(action, name, value)

    def _wait_on(self, deadline: float) -> bool:
        while self.running and (remaining := deadline - time.monotonic()) > 0:
            if self._waiter.wait(remaining):
                return True
            for beat in self.beats:
                beat()
        return False

    def _open_rpc(self, port: str) -> RpcServer:
        server = RpcServer(self.session, check_name(port, "rpc"), self._waiter)
        server.add("status", self.status, "state of this service")
        server.add("param", self._param, "list, get or set a parameter")
        self._servers.append(server)
        self.ports.add(server)
        return server

    def _prepare(self) -> None:
        for callback in self.on_ready:
            callback()

    def _now(self) -> tuple[int, int]:
        """Return the stamp [ns], and its clock, of what is not derived from a message."""
        return self.lockstep.now() if self.lockstep.enabled else self.clock.now()

    def _is_here(self, name: str, source: bytes) -> bool:
        owner = self.directory.owner(name)
        return owner is not None and owner.source == source and owner.owner.host == self.owner.host

    def _exists(self, name: str) -> bool:
        return self.directory.leader(name) is not None

    def _on_port(self, token: Token) -> None:
        if self.ports.resign(token):
            self._waiter.wake()


def _close_before_joining_threads(node: Node) -> None:
    """Close a forgotten node at exit: atexit is too late, it runs after threads are joined."""
    register = getattr(threading, "_register_atexit", None)
    reference = weakref.ref(node)

    def close() -> None:
        forgotten = reference()
        if forgotten is not None:
            forgotten.close()

    if register is not None:
        register(close)
