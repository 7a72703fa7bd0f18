"""The ports of one process, and their names."""

import time
from collections.abc import Callable, Iterator, Sequence

import zenoh

from bus.claims import (
    SETTLE,
    Asker,
    HubAbsent,
    claim,
    claim_among_peers,
    describe,
    meet_peers,
)
from bus.errors import BusError, NameTaken
from bus.input import Input
from bus.output import Output
from bus.packing import pack
from bus.rpc_server import RpcServer
from bus.tokens import Owner, Token, ready_key
from bus.wishes import WISHES

Port = Output | Input | RpcServer
CLAIM_TIMEOUT = 10.0  # s


class PortTable:
    """Claims the names of the ports, declares their tokens, and resigns when it must."""

    def __init__(
        self,
        session: zenoh.Session,
        owner: Owner,
        where: str,
        running: Callable[[], bool],
        owner_of: Callable[[str], Token | None],
        alone_since: Callable[[], float],
        take_over: bool = False,
    ):
        self.ready = False
        self.lost: NameTaken | None = None
        self._session = session
        self._owner = owner
        self._where = where
        self._running = running
        self._owner_of = owner_of
        self._alone_since = alone_since
        self._take_over = take_over
        self._ports: dict[str, Port] = {}
        self._claimed: dict[str, Token] = {}
        self._tokens: dict[str, zenoh.LivelinessToken] = {}
        self._ready_token: zenoh.LivelinessToken | None = None

    def __iter__(self) -> Iterator[Port]:
        return iter(list(self._ports.values()))

    def get(self, name: str) -> Port | None:
        """Return a port by its name."""
        return self._ports.get(name)

    def check_free(self, name: str) -> None:
        """Raise when this process has a port of that name."""
        if name in self._ports:
            raise NameTaken(f"{name} is open already in this process")

    def add(self, port: Port) -> None:
        """Take a port in; once ready, claim its name at once."""
        self._ports[port.name] = port
        if not self.ready:
            return
        try:
            self._claim([port], self._asker(CLAIM_TIMEOUT))
        except BusError:
            del self._ports[port.name]
            port.close()
            raise

    def make_ready(self, timeout: float, prepare: Callable[[], None]) -> None:
        """Claim all names, get to know everybody, and declare the readiness token last."""
        if self.ready:
            return
        asker = self._asker(timeout)
        self._claim(list(self._ports.values()), asker)
        meet_peers(self._session, asker)
        prepare()
        self.ready = True
        # who sees this token may rely on every port; it is the first to go
        self._ready_token = self._declare(ready_key(self._owner))

    def renew(self, port: Port) -> None:
        """Tell everybody that a port reads other sources than before."""
        claimed = self._claimed.get(port.name)
        if claimed is not None:
            self._stand(claimed._replace(sources=port.sources))

    def resign(self, token: Token) -> bool:
        """Give a port up when the token is a higher one on its name; called in Zenoh's thread."""
        claimed = self._claimed.get(token.name)
        if claimed is None or claimed.rank >= token.rank:
            return False
        self._ports[token.name].fall()
        self.lost = NameTaken(f"lost {token.name}: {describe(token)}")
        return True

    def close(self) -> None:
        """Close all ports; a name is given back when nothing is written on it any more."""
        if self._ready_token is not None:
            self._ready_token.undeclare()
        for port in self._ports.values():
            port.close()
        for token in self._tokens.values():
            token.undeclare()

    def _asker(self, timeout: float) -> Asker:
        return Asker(self._where, timeout, self._running, self._alone_since())

    def _claim(self, ports: Sequence[Port], asker: Asker) -> None:
        try:
            self._grant_wishes(ports, asker)
            tokens = [self._token(port) for port in ports]
            tokens = claim(self._session, tokens, asker, self._take_over)
            self._stand(*tokens)
        except HubAbsent:
            tokens = [self._token(port) for port in ports]
            tokens = claim_among_peers(tokens, self._owner_of, self._take_over)
            self._stand(*tokens)
            self._await_rivals(tokens)
        for port, token in zip(ports, tokens, strict=True):
            port.epoch = token.epoch
            port.stand()

    def _grant_wishes(self, ports: Sequence[Port], asker: Asker) -> None:
        """Connect the inputs as third parties asked for good."""
        inputs = {port.name: port for port in ports if isinstance(port, Input)}
        if not inputs:
            return
        wishes = asker.ask(self._session, WISHES, pack(["of", list(inputs)]))
        for sink, wanted in wishes.items():
            for source, connected in wanted.items():
                if connected:
                    inputs[sink].connect(source)
                elif source in inputs[sink].sources:
                    inputs[sink].disconnect(source)

    def _await_rivals(self, tokens: Sequence[Token]) -> None:
        """Let those claim who do so at the same time; give all back when one of them wins.

        A higher token may have come since we looked, before there was anything to resign.
        """
        for token in tokens:
            if (owner := self._owner_of(token.name)) is not None:
                self.resign(owner)
        deadline = time.monotonic() + SETTLE
        while self.lost is None and time.monotonic() < deadline:
            time.sleep(0.01)
        lost, self.lost = self.lost, None
        if lost is not None:
            for token in tokens:
                self._claimed.pop(token.name)
                self._tokens.pop(token.name).undeclare()
            raise lost

    def _stand(self, *tokens: Token) -> None:
        """Declare tokens, and after them undeclare those that they replace."""
        for token in tokens:
            self._claimed[token.name] = token
            replaced = self._tokens.get(token.name)
            self._tokens[token.name] = self._declare(token.key())
            if replaced is not None:
                replaced.undeclare()

    def _declare(self, key: str) -> zenoh.LivelinessToken:
        return self._session.liveliness().declare_token(key)

    def _token(self, port: Port) -> Token:
        return Token(
            *(port.name, port.direction, port.type_name, port.rate, self._owner),
            *(port.epoch, port.source, port.sources),
        )
