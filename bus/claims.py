"""Owned names: asking the hub for names, and the hub's answer.

A claim is one request to the hub with the tokens that the claimant wants to
declare. The hub grants all of them or none, and remembers a grant until the
token stands, so of simultaneous claimants exactly one wins. When two stand on a
name all the same (the hub was restarted, a network was cut), the lower (epoch,
source) resigns by itself. A take-over claims the names in a higher epoch.
"""

import threading
import time
from collections.abc import Callable
from datetime import datetime
from typing import Any

import zenoh
from zenoh.handlers import Callback

from bus.envelope import opened_at
from bus.errors import BusError, NameTaken
from bus.packing import pack, unpack
from bus.rpc import Request
from bus.tokens import PORT, Token

CLAIM, PEERS, OWNERS = "@wb/hub/claim", "@wb/hub/peers", "@wb/hub/owners"
GRANT = 2.0  # s for which a granted name waits for its token
PATIENCE = 0.3  # s for which a taken name is asked for again
SETTLE = 0.4  # s for which a claim without a hub waits for others
ALONE = 1.0  # s without a link to a hub after which peers agree on names among themselves
MEET = 0.5  # s for which we wait to be linked with all peers
MAX_REQUEST = 1 << 20  # bytes


def claim(
    session: zenoh.Session, tokens: list[Token], asker: "Asker", take_over: bool = False
) -> list[Token]:
    """Return the tokens as granted by the hub; raise NameTaken, or BusError when none answers.

    A name is asked for again for a moment: its former owner may just have gone. With
    ``take_over`` names that others have are claimed in an epoch above theirs.
    """
    started = time.monotonic()
    while taken := asker.ask(session, CLAIM, pack([token.key() for token in tokens])):
        owners = [token for key, _ in taken if (token := Token.parse(key)) is not None]
        patience = PATIENCE + (GRANT if any(granted for _, granted in taken) else 0.0)
        if time.monotonic() > started + patience:
            raise NameTaken(_describe_all(owners))
        if take_over:
            tokens = above(tokens, owners)
        else:
            time.sleep(0.02)
    return tokens


def above(tokens: list[Token], owners: list[Token]) -> list[Token]:
    """Return the tokens in epochs above those of the present owners of their names."""
    highest = {token.name: token.epoch - 1 for token in tokens}
    for owner in owners:
        highest[owner.name] = max(highest[owner.name], owner.epoch)
    return [token._replace(epoch=highest[token.name] + 1) for token in tokens]


def claim_among_peers(
    tokens: list[Token], owner_of: Callable[[str], Token | None], take_over: bool = False
) -> list[Token]:
    """Return the tokens to declare where no hub answers; raise NameTaken.

    Who is seen keeps the name. Of two that claim it at once both declare, and the
    lower resigns: so write nothing before `SETTLE` has passed.
    """
    owners = [owner for token in tokens if (owner := owner_of(token.name)) is not None]
    if owners and not take_over:
        raise NameTaken(_describe_all(owners))
    return above(tokens, owners)


def meet_peers(session: zenoh.Session, asker: "Asker") -> None:
    """Wait (not for long) until we are linked with everybody who is linked with the hub.

    Until then what we write would miss some, and what they write would miss us.
    """
    try:
        others = set(asker.ask(session, PEERS, b"")) - {str(session.zid())}
    except HubAbsent:
        return
    deadline = time.monotonic() + MEET
    while not others <= {str(peer) for peer in session.info.peers_zid()}:
        if time.monotonic() > deadline:  # somebody is stopped, or came and went
            return
        time.sleep(0.005)


class HubAbsent(BusError):
    """There is no hub, but there are peers."""


class Asker:
    """Asks the hub until it answers, until a deadline, or until the process is to end.

    Args:
        alone_since: Since when we are not linked with a hub, monotonic [s]; None is now.
    """

    def __init__(
        self,
        where: str,
        timeout: float,
        running: Callable[[], bool],
        alone_since: float | None = None,
    ):
        self._where = where
        self._timeout = timeout
        self._alone_at = (time.monotonic() if alone_since is None else alone_since) + ALONE
        self._deadline = time.monotonic() + timeout
        self._running = running

    def ask(self, session: zenoh.Session, key: str, payload: bytes) -> Any:
        """Return the hub's answer."""
        pause = 0.001
        while True:
            request = Request(session, key, payload, timeout=1.0)
            while not request.done and time.monotonic() < self._deadline and self._running():
                request.wait(0.05)
            if request.values:
                return request.values[0]
            self._check(request)
            if self._is_absent(session):
                raise HubAbsent(f"no hub at {self._where}")
            time.sleep(pause)  # the link to the hub comes within milliseconds, when there is one
            pause = min(2 * pause, 0.05)

    def _is_absent(self, session: zenoh.Session) -> bool:
        info = session.info
        return (
            time.monotonic() > self._alone_at
            and not list(info.routers_zid())
            and bool(list(info.peers_zid()))
        )

    def _check(self, request: Request) -> None:
        if not self._running():
            raise BusError("asked to end before the hub answered")
        if time.monotonic() >= self._deadline:
            trouble = request.trouble() or "is it running?"
            raise BusError(
                f"no hub at {self._where} answered within {self._timeout:g} s: {trouble}"
            )


def describe(*tokens: Token) -> str:
    """Return who has one or more names, and since when."""
    names = [token.name for token in tokens]
    listed = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
    first = min(tokens, key=lambda token: token.source)
    since = datetime.fromtimestamp(opened_at(first.source) / 1e9).strftime("%H:%M:%S")
    verb = "name {} is" if len(names) == 1 else "names {} are"
    return f"the {verb.format(listed)} taken by {first.owner}, since {since}"


def _describe_all(tokens: list[Token]) -> str:
    owners = sorted({token.owner for token in tokens})
    return "; ".join(describe(*(t for t in tokens if t.owner == owner)) for owner in owners)


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
        self._session = session
        self._queryables = [
            session.declare_queryable(f"**/{key}", Callback(answer, indirect=False))
            for key, answer in (
                (CLAIM, self._answer),
                (PEERS, self._tell_peers),
                (OWNERS, self._tell_owners),
            )
        ]

    def close(self) -> None:
        """Answer no more."""
        for queryable in self._queryables:
            queryable.undeclare()
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
            query.reply_err(pack({"error": "the hub has just started"}))
            return
        try:
            namespace = str(query.key_expr).partition("@wb")[0]
            taken = self.decide(namespace, _read(query))
            query.reply(query.key_expr, pack(taken))
        except ValueError as error:
            query.reply_err(pack({"error": f"bad claim: {error}"}))

    def _tell_peers(self, query: zenoh.Query) -> None:
        peers = [str(peer) for peer in self._session.info.peers_zid()]
        query.reply(query.key_expr, pack(peers))

    def _tell_owners(self, query: zenoh.Query) -> None:
        namespace = str(query.key_expr).partition("@wb")[0]
        name = "" if query.payload is None else query.payload.to_bytes().decode(errors="replace")
        query.reply(query.key_expr, pack(self.owners(namespace, name)))

    def owners(self, namespace: str, name: str = "") -> list[str]:
        """Return the sessions that have names in a namespace, or one name."""
        with self._lock:
            standing = [(place, list(tokens.values())) for place, tokens in self._standing.items()]
        return sorted(
            {
                token.owner.node
                for place, tokens in standing
                for token in tokens
                if place == namespace + token.name and name in ("", token.name)
            }
        )

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
            if other.source != token.source and other.epoch >= token.epoch
        ]
        granted, until = self._granted.get(place, (token, 0.0))
        if granted.source != token.source and granted.epoch >= token.epoch and until > now:
            others.append((granted.key(), True))
        return others


def _read(query: zenoh.Query) -> list[Token]:
    payload = query.payload
    if payload is None or len(payload) > MAX_REQUEST:
        raise ValueError("expected a list of token keys")
    keys = unpack(payload.to_bytes())
    listed = keys if isinstance(keys, list) else ()
    tokens = [Token.parse(key) for key in listed if isinstance(key, str)]
    if not isinstance(keys, list) or len(tokens) != len(keys) or None in tokens:
        raise ValueError(f"expected a list of token keys, got {keys!r:.100}")
    return [token for token in tokens if token is not None]
