"""What stands on the bus at present, as seen by one session through liveliness tokens."""

import threading
from collections.abc import Callable

import zenoh
from zenoh.handlers import Callback

from bus.threads import adopt
from bus.tokens import PORT, READY, Owner, Token, parse_ready

Listener = Callable[[Token], None]


class Directory:
    """All standing ports and ready services, kept up to date in Zenoh's own thread.

    Direct callbacks: they need no thread of ours (which would keep the process
    from exiting), and a token is known before the data that follows it on a link.
    """

    def __init__(self, session: zenoh.Session, on_port: Listener | None = None):
        self._ports: dict[str, dict[str, Token]] = {}
        self._known: dict[str, Token] = {}  # that stand, by key
        self._ready: dict[str, Owner] = {}
        self._leaders: dict[str, bytes] = {}
        self._on_port = on_port
        self._lock = threading.Lock()
        declare = session.liveliness().declare_subscriber
        self._subscribers = [
            declare(f"{PORT}/**", Callback(self._port_event, indirect=False), history=True),
            declare(f"{READY}/**", Callback(self._ready_event, indirect=False), history=True),
        ]

    def close(self) -> None:
        """Stop listening."""
        for subscriber in self._subscribers:
            subscriber.undeclare()

    def leader(self, name: str) -> bytes | None:
        """Return the source to follow on a name: the highest (epoch, source), or None."""
        return self._leaders.get(name)

    def owner(self, name: str) -> Token | None:
        """Return the token that leads a name."""
        standing = list(self._ports.get(name, {}).values())
        return max(standing, key=lambda token: token.rank, default=None)

    def names(self) -> list[str]:
        """Return all standing port names, sorted."""
        return sorted(name for name, standing in self._ports.copy().items() if standing)

    def tokens(self) -> list[Token]:
        """Return the leading token of every standing name, sorted by name."""
        return [token for name in self.names() if (token := self.owner(name)) is not None]

    def sessions(self) -> set[str]:
        """Return the sessions that have names."""
        return {token.owner.node for token in list(self._known.values())}

    def services(self) -> list[Owner]:
        """Return the services that are ready, sorted."""
        return sorted(self._ready.copy().values())

    def _port_event(self, sample: zenoh.Sample) -> None:
        adopt()
        key = str(sample.key_expr)
        token = self._known.pop(key, None) or Token.parse(key)
        if token is None:
            return
        with self._lock:  # several links, several threads of Zenoh's
            standing = dict(self._ports.get(token.name, {}))
            if sample.kind == zenoh.SampleKind.PUT:
                standing[key] = self._known[key] = token
            else:
                standing.pop(key, None)
            self._replace(token.name, standing)
        if sample.kind == zenoh.SampleKind.PUT and self._on_port is not None:
            self._on_port(token)

    def _replace(self, name: str, standing: dict[str, Token]) -> None:
        if standing:
            self._ports[name] = standing
            self._leaders[name] = max(standing.values(), key=lambda token: token.rank).source
        else:
            self._ports.pop(name, None)
            self._leaders.pop(name, None)

    def _ready_event(self, sample: zenoh.Sample) -> None:
        adopt()
        key = str(sample.key_expr)
        owner = parse_ready(key)
        if owner is None:
            return
        if sample.kind == zenoh.SampleKind.PUT:
            self._ready[key] = owner
        else:
            self._ready.pop(key, None)
