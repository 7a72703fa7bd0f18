"""Asking a port's owner what the port carries, without waiting for the answer."""

import time
from typing import Any

from bus.errors import BusError
from bus.information import INFORMATION
from bus.node import Node
from bus.rpc import Request, result_of
from bus.tokens import Token

ANSWER = 2.0  # s; then it is asked again


class Description:
    """What the owner of a port tells of it, sooner or later."""

    def __init__(self, node: Node, token: Token):
        self.token = token
        self._node = node
        self._ask()

    def _ask(self) -> None:
        key, name = f"{INFORMATION}/{self.token.owner.node}", self.token.name.encode()
        self._request = Request(self._node.session, key, name, ANSWER)
        self._overdue = time.monotonic() + ANSWER

    @property
    def least(self) -> dict[str, Any]:
        """What its token alone tells."""
        token = self.token
        owner = {"service": token.owner.service, "host": token.owner.host}
        return {
            "type": token.type,
            "direction": token.direction,
            "nominal_hz": token.rate,
            "owner": owner,
        }

    def told(self) -> dict[str, Any] | None:
        """Return everything once it has been told, else None."""
        if not self._request.done:
            return None
        try:
            return self.least | result_of(self._request, self.token.name, "info", ANSWER)
        except BusError:
            return None

    def renew(self) -> bool:
        """Return whether an answer is overdue; it is asked for again then."""
        overdue = time.monotonic() > self._overdue
        if overdue:
            self._ask()
        return overdue
