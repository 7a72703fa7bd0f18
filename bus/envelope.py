"""What travels with every datum."""

import os
import time
from typing import Any, NamedTuple

from bus.errors import WireError
from bus.packing import unpack

WALL, SIMULATED = 0, 1


class Envelope(NamedTuple):
    """The part of a message that is the same for all types.

    ``source`` is new at every opening of the port and begins with the opening's
    wall time, so that of two sources the later one is the higher. ``stamp`` is the
    time of measurement in the session's clock [ns], ``clock`` says which one (0
    wall, 1 simulated), ``acquired`` and ``sent`` are wall times [ns].
    """

    type: str
    source: bytes
    epoch: int
    seq: int
    stamp: int
    clock: int
    acquired: int
    sent: int
    valid: bool
    reason: str
    model: str


class Received(NamedTuple):
    """One message as an input hands it out; ``arrival`` is monotonic [ns]."""

    data: Any
    envelope: Envelope
    arrival: int


def new_source() -> bytes:
    """Return 16 bytes: wall time [ns], big-endian, and 8 random bytes."""
    return time.time_ns().to_bytes(8, "big") + os.urandom(8)


def opened_at(source: bytes) -> int:
    """Return the wall time at which a source was opened [ns]."""
    return int.from_bytes(source[:8], "big")


_KINDS = (str, bytes, int, int, int, int, int, int, bool, str, str)


def envelope_of(data: bytes) -> Envelope:
    """Return the envelope of a message whose type is not known; raise WireError without one."""
    try:
        head = unpack(data)[: len(_KINDS)]
    except (ValueError, TypeError) as error:
        raise WireError(f"not a message: {error}") from None
    if type(head) is not list or tuple(map(type, head)) != _KINDS or len(head[1]) != 16:
        raise WireError("not a message: bad envelope")
    return Envelope(*head)
