"""Answering RPC: requests come in Zenoh's thread and are handled in the main thread."""

import inspect
import logging
import threading
from collections import deque
from collections.abc import Callable
from typing import Any

import zenoh
from zenoh.handlers import Callback

from bus.envelope import new_source
from bus.errors import BusError
from bus.names import did_you_mean, key_of
from bus.packing import pack, unpack
from bus.rpc import MAX_REQUEST
from bus.schema import plain
from bus.signature import Contract
from bus.waiter import Waiter

logger = logging.getLogger(__name__)

Handler = Callable[..., Any]
WAITING = 256  # requests; a port that does not get to its requests refuses more


class Pending:
    """Returned by a handler that answers later, from any thread, by `reply` or `fail`."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._query: zenoh.Query | None = None
        self._answer: tuple[bool, Any] | None = None

    def reply(self, value: Any) -> None:
        """Answer with a value."""
        self._settle(True, value)

    def fail(self, text: str) -> None:
        """Answer with an error."""
        self._settle(False, text)

    def attach(self, query: zenoh.Query) -> None:
        """Say to whom the answer goes; called by the bus."""
        with self._lock:
            self._query = query
            answer = self._answer
        if answer is not None:
            send(query, *answer)

    def _settle(self, ok: bool, value: Any) -> None:
        with self._lock:
            if self._answer is not None:
                raise RuntimeError("this request is already answered")
            self._answer = ok, value
            query = self._query
        if query is not None:
            send(query, ok, value)

    @property
    def open(self) -> bool:
        """Whether no answer was given yet."""
        return self._answer is None


class RpcServer:
    """One RPC port with its verbs."""

    direction = "rpc"
    rate = 0.0
    type_name = "rpc"
    sources: tuple[str, ...] = ()

    def __init__(self, session: zenoh.Session, name: str, waiter: Waiter):
        self.name = name
        self.source = new_source()
        self.epoch = 0
        self.answered = 0
        self._verbs: dict[str, tuple[Handler, str, Contract]] = {}
        self._queries: deque[zenoh.Query] = deque()
        self._pending: list[Pending] = []
        self._waiter = waiter
        self._session = session
        self._queryable: zenoh.Queryable | None = None
        self.add("help", self._help, "what this port understands")

    def stand(self) -> None:
        """The name is ours: answer from now on."""
        callback = Callback(self._on_query, indirect=False)
        self._queryable = self._session.declare_queryable(key_of(self.name), callback)

    def fall(self) -> None:
        """The name is lost: answer nothing any more."""
        queryable, self._queryable = self._queryable, None
        if queryable is not None:
            queryable.undeclare()

    def add(self, verb: str, handler: Handler, help: str = "") -> None:
        """Add a verb; ``help`` defaults to the first line of the handler's docstring.

        What the handler's annotations declare (`bus.signature`) is checked before it is
        called and when it has answered.
        """
        text = help or (inspect.getdoc(handler) or "").partition("\n")[0]
        self._verbs[verb] = handler, text, Contract(handler)

    @property
    def waiting(self) -> bool:
        """Whether requests wait to be handled."""
        return bool(self._queries)

    def run(self) -> None:
        """Handle the requests that wait."""
        while self._queries:
            self._handle(self._queries.popleft())

    def info(self) -> dict[str, Any]:
        """Return what `bus.introspection.port_info` shows."""
        return {
            "description": "RPC",
            "verbs": self._help(),
            "statistics": {"answered": self.answered},
        }

    def close(self) -> None:
        """Answer no more; whoever still waits is told."""
        self.fall()
        for query in self._queries:
            send(query, False, f"{self.name} is closing")
        for pending in self._pending:
            if pending.open:
                pending.fail(f"{self.name} is closing")

    def _on_query(self, query: zenoh.Query) -> None:
        if len(self._queries) >= WAITING:
            send(query, False, f"{self.name} has {WAITING} requests waiting already")
            return
        self._queries.append(query)
        self._waiter.wake()

    def _handle(self, query: zenoh.Query) -> None:
        self.answered += 1
        try:
            verb, arguments = self._parse(query)
            value = self._call(verb, arguments)
        except Exception as error:  # whatever a handler raises is the caller's to read
            send(query, False, _text(error))
            return
        if isinstance(value, Pending):
            self._pending = [pending for pending in self._pending if pending.open] + [value]
            value.attach(query)
        else:
            send(query, True, value)

    def _parse(self, query: zenoh.Query) -> tuple[str, dict[str, Any]]:
        payload = query.payload
        if payload is None or len(payload) > MAX_REQUEST:
            raise ValueError(f"expected a request of at most {MAX_REQUEST} bytes")
        request = unpack(payload.to_bytes())
        match request:
            case [str() as verb, dict() as arguments] if all(type(k) is str for k in arguments):
                return verb, arguments
        raise ValueError(f"expected [verb, {{argument: value}}], got {request!r:.100}")

    def _call(self, verb: str, arguments: dict[str, Any]) -> Any:
        if verb not in self._verbs:
            known = ", ".join(self._verbs)
            raise ValueError(
                f"unknown verb {verb!r:.60}{did_you_mean(verb, self._verbs)}; there are: {known}"
            )
        handler, _, contract = self._verbs[verb]
        try:
            arguments = contract.bind(arguments)
        except ValueError as error:
            raise ValueError(f"{verb}: {error}") from None
        try:
            value = handler(**arguments)
        except (ValueError, LookupError, RuntimeError, BusError):
            raise
        except Exception:
            logger.exception("%s: verb %s failed", self.name, verb)
            raise
        return value if isinstance(value, Pending) else contract.answer(value)

    def _help(self) -> dict[str, str]:
        return {
            f"{verb}{contract.usage}": text for verb, (_, text, contract) in self._verbs.items()
        }


def send(query: zenoh.Query, ok: bool, value: Any) -> None:
    """Send one answer; a value that cannot travel becomes an error."""
    try:
        if ok:
            query.reply(query.key_expr, pack(plain(value, "answer")))
        else:
            query.reply_err(pack({"error": str(value)}))
        query.drop()  # ends the asker's wait; the object may live on in a traceback
    except ValueError as error:
        send(query, False, str(error))
    except zenoh.ZError as error:
        logger.warning("an answer could not be sent: %s", error)


def _text(error: Exception) -> str:
    if isinstance(error, KeyError) and error.args:
        return str(error.args[0])
    return str(error) or type(error).__name__
