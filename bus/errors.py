"""What can go wrong on the bus, as exceptions that say what, got, expected and what exists."""


class BusError(Exception):
    """Something the bus was asked for cannot be done."""


class WireError(BusError, ValueError):
    """A message does not fit its type: bad bytes, types, shapes, sizes or numbers."""


class NameTaken(BusError):
    """A port's name is owned by another process."""


class RpcError(BusError):
    """The other side's handler refused; the text is the handler's."""


class RpcAbsent(RpcError):
    """Nobody answers on the RPC port."""


class RpcTimeout(RpcError):
    """The RPC port exists but did not answer in time."""


class LockstepTimeout(BusError):
    """A participant did not acknowledge a stamp in time."""
