"""Owned names: asking the hub for names, and the hub's answer.

A claim is one request to the hub with the tokens that the claimant wants to
declare. The hub grants all of them or none, and remembers a grant until the
token stands, so of simultaneous claimants exactly one wins. When two stand on a
name all the same (the hub was restarted, a network was cut), the lower (epoch,
source) resigns by itself.
"""

import threading
import time
from datetime import datetime

import msgpack
import zenoh
from zenoh.handlers import Callback

from bus.envelope import opened_at
from bus.errors import BusError, NameTaken
from bus.rpc import Request
from bus.tokens import PORT, Token

CLAIM = "@wb/hub/claim"
GRANT = 2.0  # s for which a granted name waits for its token
MAX_REQUEST = 1 << 20  # bytes


def claim(session: zenoh.Session, tokens: list[Token], deadline: float, where: str) -> None:
    """Return when the hub grants all names; raise NameTaken, or BusError when no hub answers.

    A name is asked for again for a moment: its former owner may just have gone.
    """
    payload = msgpack.packb([token.key() for token in tokens])
    patience = time.monotonic() + 0.3
    while True:
        taken = _ask(session, payload, deadline, where)
        if not taken:
            return
        standing = [(Token.parse(key), pending) for key, pending in taken]
        waits = GRANT + 0.3 if any(pending for _, pending in standing) else 0.3
        if time.monotonic() > min(deadline, patience - 0.3 + waits):
            raise NameTaken("; ".join(describe(token) for token, _ in standing if token))
        time.sleep(0.02)


def _ask(session: zenoh.Session, payload: bytes, deadline: float, where: str) -> list:
    while True:
        request = Request(session, CLAIM, payload, timeout=1.0)
        while not request.done and time.monotonic() < deadline:
            request.wait(0.05)
        if request.values:
            return request.values[0]
        if time.monotonic() >= deadline:
            raise BusError(f"no hub answers at {where}: is it running? {request.trouble()}".strip())
        time.sleep(0.02)


def describe(token: Token) -> str:
    """Return who has a name, and since when."""
    since = datetime.fromtimestamp(opened_at(token.source) / 1e9).strftime("%H:%M:%S")
    return f"the name {token.name} is taken by {token.owner}, since {since}"


class Arbiter:
    """Grants names; runs in the hub, for all namespaces."""

    def __init__(self, session: zenoh.Session, settle: float = 0.0):
        self._standing: dict[str, dict[str, Token]] = {}
        self._granted: dict[str, tuple[Token, float]] = {}
        self._lock = threading.Lock()
        # after a restart the peers need a moment to come back with their names
        self._open_at = time.monotonic() + settle
        self._subscriber = session.liveliness().declare_subscriber(
            f"**/{PORT}/**", Callback(self._event, indirect=False), history=True
        )
        self._queryable = session.declare_queryable(
            f"**/{CLAIM}", Callback(self._answer, indirect=False)
        )

    def close(self) -> None:
        """Answer no more."""
        self._queryable.undeclare()
        self._subscriber.undeclare()

    def _event(self, sample: zenoh.Sample) -> None:
        key = str(sample.key_expr)
        token = Token.parse(key)
        if token is None:
            return
        place = key.partition("@wb")[0] + token.name
        with self._lock:
            standing = self._standing.setdefault(place, {})
            if sample.kind == zenoh.SampleKind.PUT:
                standing[key] = token
                self._granted.pop(place, None)
            else:
                standing.pop(key, None)
            if not standing:
                del self._standing[place]

    def _answer(self, query: zenoh.Query) -> None:
        if time.monotonic() < self._open_at:
            query.reply_err(msgpack.packb({"error": "the hub has just started"}))
            return
        try:
            namespace = str(query.key_expr).partition("@wb")[0]
            taken = self.decide(namespace, _read(query))
            query.reply(query.key_expr, msgpack.packb(taken))
        except ValueError as error:
            query.reply_err(msgpack.packb({"error": f"bad claim: {error}"}))

    def decide(self, namespace: str, wanted: list[Token]) -> list[tuple[str, bool]]:
        """Return ``(token key, only granted yet)`` of the owners in the way; grant all if none."""
        now = time.monotonic()
        with self._lock:
            taken = [item for token in wanted for item in self._in_the_way(namespace, token, now)]
            if not taken:
                for token in wanted:
                    self._granted[namespace + token.name] = (token, now + GRANT)
        return taken

    def _in_the_way(self, namespace: str, token: Token, now: float) -> list[tuple[str, bool]]:
        place = namespace + token.name
        others = [
            (other.key(), False)
            for other in self._standing.get(place, {}).values()
            if other.source != token.source
        ]
        granted, until = self._granted.get(place, (token, 0.0))
        if granted.source != token.source and until > now:
            others.append((granted.key(), True))
        return others


def _read(query: zenoh.Query) -> list[Token]:
    payload = query.payload
    if payload is None or len(payload) > MAX_REQUEST:
        raise ValueError("expected a list of token keys")
    keys = msgpack.unpackb(payload.to_bytes())
    tokens = [Token.parse(key) for key in keys if isinstance(key, str)]
    if not isinstance(keys, list) or len(tokens) != len(keys) or None in tokens:
        raise ValueError(f"expected a list of token keys, got {keys!r:.100}")
    return [token for token in tokens if token is not None]
