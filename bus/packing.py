"""MessagePack, as all control traffic uses it."""

from typing import Any

import msgpack


def pack(value: Any) -> bytes:
    """Return plain values (None, bool, int, float, str, bytes, list, dict) as MessagePack."""
    return bytes(msgpack.packb(value))  # type: ignore[arg-type]  # its stub allows None


def unpack(data: bytes) -> Any:
    """Return the values; raise ValueError when the bytes are not one MessagePack value."""
    return msgpack.unpackb(data)
