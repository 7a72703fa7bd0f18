"""Ports over Zenoh: typed messages, owned names, RPC, clocks. Knows nothing of robots."""

from bus.envelope import Envelope, Received
from bus.errors import (
    BusError,
    LockstepTimeout,
    NameTaken,
    RpcAbsent,
    RpcError,
    RpcTimeout,
    WireError,
)
from bus.input import Input
from bus.node import Node
from bus.output import Output
from bus.rpc import call
from bus.rpc_server import Pending

__all__ = [
    "BusError",
    "Envelope",
    "Input",
    "LockstepTimeout",
    "NameTaken",
    "Node",
    "Output",
    "Pending",
    "Received",
    "RpcAbsent",
    "RpcError",
    "RpcTimeout",
    "WireError",
    "call",
]
