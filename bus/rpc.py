"""Asking an RPC port: ``[verb, {argument: value}]`` in, a value or a text of error out."""

import time
from typing import Any, Protocol

import zenoh
from zenoh.handlers import Callback

from bus.errors import BusError, RpcAbsent, RpcError, RpcTimeout, WireError
from bus.names import key_of
from bus.packing import pack, unpack
from bus.schema import plain
from bus.signature import typed
from bus.waiter import Waiter

MAX_REQUEST = 65536  # bytes
ABSENCE = 1.0  # s; a young session does not see everybody yet, so an empty answer is asked again


class Request:
    """One question on a key; the answers come in Zenoh's thread, the asker polls or waits."""

    def __init__(
        self,
        session: zenoh.Session,
        key: str,
        payload: bytes,
        timeout: float,
        waiter: Waiter | None = None,
    ):
        self.done = False
        self.values: list[Any] = []
        self.errors: list[str] = []
        self.timed_out = False
        self._waiter = waiter or Waiter()
        session.get(
            key,
            Callback(self._on_reply, self._on_end, indirect=False),
            payload=payload,
            timeout=timeout,
            target=zenoh.QueryTarget.ALL,
            consolidation=zenoh.ConsolidationMode.NONE,
        )

    def wait(self, timeout: float) -> bool:
        """Wait at most ``timeout`` (and at most 0.1 s) for the end; return whether it came."""
        if not self.done:
            self._waiter.wait(timeout)
        return self.done

    def trouble(self) -> str:
        """Return what went wrong so far, in words."""
        return "; ".join(self.errors)

    def _on_reply(self, reply: zenoh.Reply) -> None:
        try:
            if reply.ok is not None:
                self.values.append(unpack(reply.ok.payload.to_bytes()))
            else:
                self._on_error(reply.err.payload.to_bytes())  # type: ignore[union-attr]
        except Exception as error:  # from outside: whatever it holds, the asker must not hang
            self.errors.append(f"unreadable answer: {error}")

    def _on_error(self, payload: bytes) -> None:
        if payload == b"Timeout":  # Zenoh's own; ours are maps
            self.timed_out = True
            return
        self.errors.append(str(unpack(payload)["error"]))

    def _on_end(self) -> None:
        self.done = True
        self._waiter.wake()


class HasSession(Protocol):
    """A node, or anything else with an open session."""

    session: zenoh.Session

    @property
    def running(self) -> bool: ...


def pack_request(verb: str, arguments: dict[str, Any] | None) -> bytes:
    """Return the bytes of a request."""
    payload = pack([verb, plain(arguments or {}, "arguments")])
    if len(payload) > MAX_REQUEST:
        raise RpcError(f"request of {len(payload)} bytes, at most {MAX_REQUEST} are allowed")
    return payload


def call(
    node: "HasSession | zenoh.Session",
    port: str,
    verb: str,
    arguments: dict[str, Any] | None = None,
    timeout: float = 5.0,
    returns: Any = Any,
) -> Any:
    """Ask an RPC port and return the answer, as ``returns`` declares it (see `bus.signature`).

    Dataclasses among the arguments travel as maps. Raises RpcAbsent (nobody there),
    RpcTimeout (somebody there, no answer), RpcError (the handler's own text, several
    servers, or an answer of another type), BusError when this process is asked to end
    meanwhile.
    """
    session = node if isinstance(node, zenoh.Session) else node.session
    payload, key = pack_request(verb, arguments), key_of(port)
    deadline = time.monotonic() + timeout
    absent_until = min(deadline, time.monotonic() + ABSENCE)
    while True:
        request = Request(session, key, payload, max(deadline - time.monotonic(), 0.001))
        _await(request, node, port, deadline)
        if request.values or request.errors or request.timed_out:
            answer = result_of(request, port, verb, timeout)
            return _as_declared(answer, returns, port, verb)
        if not request.done:
            raise RpcTimeout(f"{port} {verb}: no answer within {timeout:g} s")
        now = time.monotonic()
        if now >= absent_until and not getattr(node, "stands", _nothing_stands)(port):
            raise RpcAbsent(f"nobody answers on {port}")
        if now >= deadline:
            raise RpcTimeout(f"{port} {verb}: its owner was not reached within {timeout:g} s")
        time.sleep(0.02)


def _as_declared(answer: Any, returns: Any, port: str, verb: str) -> Any:
    try:
        return typed(returns, "answer")(answer)
    except WireError as error:
        raise RpcError(f"{port} {verb}: {error}") from None


def _nothing_stands(_: str) -> bool:
    return False  # as far as a bare session can tell


def _await(request: Request, node: Any, port: str, deadline: float) -> None:
    while not request.done and time.monotonic() < deadline + 0.1:
        request.wait(deadline + 0.1 - time.monotonic())
        if not getattr(node, "running", True):
            raise BusError(f"asked to end while waiting for {port}")


def result_of(request: Request, port: str, verb: str, timeout: float) -> Any:
    """Return the single value of a finished request, or raise what it means."""
    answers = len(request.values) + len(request.errors)
    if answers > 1:
        raise RpcError(f"{answers} servers answer on {port}; expected one")
    if request.errors:
        raise RpcError(request.errors[0])
    if request.values:
        return request.values[0]
    if request.timed_out:
        raise RpcTimeout(f"{port} {verb}: no answer within {timeout:g} s")
    raise RpcAbsent(f"nobody answers on {port}")
