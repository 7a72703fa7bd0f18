"""The ports of one process, and their names."""

from collections.abc import Callable, Iterator, Sequence

import zenoh

from bus.claims import Asker, claim, describe, meet_peers
from bus.errors import NameTaken
from bus.input import Input
from bus.output import Output
from bus.rpc_server import RpcServer
from bus.tokens import Owner, Token, ready_key

Port = Output | Input | RpcServer
CLAIM_TIMEOUT = 10.0  # s


class PortTable:
    """Claims the names of the ports, declares their tokens, and resigns when it must."""

    def __init__(
        self, session: zenoh.Session, owner: Owner, where: str, running: Callable[[], bool]
    ):
        self.ready = False
        self.lost: NameTaken | None = None
        self._session = session
        self._owner = owner
        self._where = where
        self._running = running
        self._ports: dict[str, Port] = {}
        self._tokens: list[zenoh.LivelinessToken] = []

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
        if self.ready:
            self._claim([port], Asker(self._where, CLAIM_TIMEOUT, self._running))

    def make_ready(self, timeout: float, prepare: Callable[[], None]) -> None:
        """Claim all names, get to know everybody, and declare the readiness token last."""
        if self.ready:
            return
        asker = Asker(self._where, timeout, self._running)
        self._claim(list(self._ports.values()), asker)
        meet_peers(self._session, asker)
        prepare()
        self.ready = True
        key = ready_key(self._owner)
        # who sees this token may rely on every port; it is the first to go
        self._tokens.insert(0, self._session.liveliness().declare_token(key))

    def resign(self, token: Token) -> bool:
        """Give a port up when the token is a higher one on its name; called in Zenoh's thread."""
        port = self._ports.get(token.name)
        if port is None or (port.epoch, port.source) >= token.rank:
            return False
        port.fall()
        self.lost = NameTaken(f"lost {token.name}: {describe(token)}")
        return True

    def close(self) -> None:
        """Close all ports; a name is given back when nothing is written on it any more."""
        for token in self._tokens[:1]:
            token.undeclare()
        for port in self._ports.values():
            port.close()
        for token in self._tokens[1:]:
            token.undeclare()

    def _claim(self, ports: Sequence[Port], asker: Asker) -> None:
        tokens = [self._token(port) for port in ports]
        claim(self._session, tokens, asker)
        declare = self._session.liveliness().declare_token
        self._tokens += [declare(token.key()) for token in tokens]
        for port in ports:
            port.stand()

    def _token(self, port: Port) -> Token:
        return Token(
            *(port.name, port.direction, port.type_name, port.rate, self._owner),
            *(port.epoch, port.source, port.sources),
        )
