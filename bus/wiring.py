"""Who reads whom, changed at run time by anybody.

An input's connections belong to its owner, which is asked over its RPC port. With
``persist`` the hub keeps the wish too, and tells it whoever opens that input later.
"""

from typing import Any, Literal, NamedTuple

from bus.claims import Asker
from bus.connector import differs
from bus.errors import BusError, RpcAbsent
from bus.introspection import hear_all, wait_for_port
from bus.names import check_name
from bus.node import Node
from bus.packing import pack
from bus.tokens import Token
from bus.wishes import WISHES


class Connection(NamedTuple):
    """That an input reads an output, or shall (not); ``persistent`` when the hub keeps the wish.

    ``state`` is ``connected``, ``waiting`` (one of the ports does not stand, or the input is
    to be opened again) or ``apart`` (disconnected for good).
    """

    source: str
    sink: str
    persistent: bool
    state: Literal["connected", "waiting", "apart"] = "connected"


def connect(
    node: Node, source: str, sink: str, persist: bool = False, timeout: float = 2.0
) -> dict[str, Any]:
    """Let an input read an output from now on; return ``{"sink", "sources"}``.

    Without ``persist`` both must stand. With it, they are connected whenever they do.

    Raises:
        BusError: A port is unknown (near names are told) or no output and input of the
            same type, or its owner does not answer.
    """
    _check_names(source, sink)
    if not persist:
        for name in (source, sink):
            wait_for_port(node, name, timeout)
    _check_pair(*_standing(node, timeout, source, sink))
    if persist:
        _wish(node, ["set", sink, source, True], timeout)
    return _ask_owner(node, "connect", source, sink, timeout, persist)


def disconnect(
    node: Node, source: str, sink: str, persist: bool = False, timeout: float = 2.0
) -> dict[str, Any]:
    """Let an input read an output no more; return ``{"sink", "sources"}``.

    With ``persist`` also whenever the input is opened, even where its settings say otherwise.

    Raises:
        BusError: The input is unknown or does not read the output, or its owner does not answer.
    """
    _check_names(source, sink)
    if persist:
        _wish(node, ["set", sink, source, False], timeout)
        reader = _standing(node, timeout, sink)[0]
        if reader is None or source not in reader.sources:
            return _connected(sink, reader)
    else:
        wait_for_port(node, sink, timeout)
    return _ask_owner(node, "disconnect", source, sink, timeout, persist)


def forget(node: Node, source: str, sink: str, timeout: float = 2.0) -> dict[str, Any]:
    """Let the hub forget what was wished of a connection; return ``{"sink", "sources"}``.

    The present connection stays as it is.

    Raises:
        BusError: A name is no output's or input's, or the hub does not answer.
    """
    _check_names(source, sink)
    _wish(node, ["forget", sink, source], timeout)
    return _connected(sink, _standing(node, timeout, sink)[0])


def connections(node: Node, timeout: float = 2.0) -> list[Connection]:
    """Return what is connected now, and what is wished for good, sorted."""
    wishes = {
        (source, sink): wanted
        for sink, wished in _wish(node, ["all"], timeout).items()
        for source, wanted in wished.items()
    }
    now = {(source, token.name) for token in node.directory.tokens() for source in token.sources}
    return [
        _connection(node, pair, pair in now, wishes.get(pair)) for pair in sorted(now | set(wishes))
    ]


def _connection(node: Node, pair: tuple[str, str], reads: bool, wished: bool | None) -> Connection:
    if reads:
        stands = node.directory.owner(pair[0]) is not None
        return Connection(*pair, bool(wished), "connected" if stands else "waiting")
    return Connection(*pair, True, "waiting" if wished else "apart")


def _check_names(source: str, sink: str) -> None:
    check_name(source, "output")
    check_name(sink, "input")


def _standing(node: Node, timeout: float, *names: str) -> list[Token | None]:
    """Return the tokens of ports, None for those that do not stand."""
    hear_all(node, lambda: all(map(node.directory.owner, names)), timeout)
    return [node.directory.owner(name) for name in names]


def _check_pair(writer: Token | None, reader: Token | None) -> None:
    for token, wanted in ((writer, "output"), (reader, "input")):
        if token is not None and token.direction != wanted:
            raise BusError(f"{token.name} is an {token.direction} port, expected an {wanted}")
    if writer is not None and reader is not None and writer.type != reader.type:
        raise BusError(differs(writer.name, writer.type, reader.name, reader.type))


def _ask_owner(
    node: Node, verb: str, source: str, sink: str, timeout: float, kept: bool
) -> dict[str, Any]:
    reader = node.directory.owner(sink)
    if reader is None:
        return _connected(sink, None)
    arguments = {"sink": sink, "source": source}
    try:
        return node.call(f"/{reader.owner.service}/rpc:i", verb, arguments, timeout)
    except RpcAbsent:
        if not kept:
            raise
        return _connected(sink, None)  # it has just gone, and hears of the wish when it is back


def _connected(sink: str, reader: Token | None) -> dict[str, Any]:
    return {"sink": sink, "sources": list(reader.sources) if reader is not None else []}


def _wish(node: Node, request: list, timeout: float) -> Any:
    asker = Asker(node.endpoint, timeout, lambda: node.running)
    return asker.ask(node.session, WISHES, pack(request))
