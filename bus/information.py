"""Every node tells what its ports are doing, without its main thread's help."""

import zenoh
from zenoh.handlers import Callback

from bus.packing import pack
from bus.port_table import PortTable
from bus.schema import plain

INFORMATION = "@wb/info"


class InformationServer:
    """Answers ``@wb/info/<node>`` with the information of the port named in the request."""

    def __init__(self, session: zenoh.Session, node: str, ports: PortTable):
        self._ports = ports
        self._queryable = session.declare_queryable(
            f"{INFORMATION}/{node}", Callback(self._answer, indirect=False)
        )

    def close(self) -> None:
        """Answer no more."""
        self._queryable.undeclare()

    def _answer(self, query: zenoh.Query) -> None:
        try:
            name = query.payload.to_bytes().decode() if query.payload is not None else ""
            port = self._ports.get(name)
            if port is None:
                raise ValueError(name)
            query.reply(query.key_expr, pack(plain(port.info())))
        except ValueError:
            query.reply_err(pack({"error": "no such port in this process"}))
