"""Compares two recordings, port by port and stamp by stamp."""

import math
from collections.abc import Collection, Iterable
from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np

from bus.decoder import Decoder
from bus.errors import WireError
from bus.recording.heads import Recorded, split
from bus.recording.reader import Recording


class Difference(NamedTuple):
    """How far the messages of one port differ; source, sent and acquired aside.

    ``largest`` is the largest difference of any number, inf where something else than
    numbers differs: a text, a flag, a shape, the validity. Messages that are invalid in
    both are alike, and one that only one has is not counted: their number and their
    reasons depend on wall time.
    """

    common: int  # stamps at which both have a message, and at least one of them is valid
    differing: int  # of them, messages that are not the same bytes
    largest: float
    only_first: int  # valid messages
    only_second: int


Messages = dict[int, tuple[Recorded, bytes]]  # by stamp [ns]


def differences(first: Recording, second: Recording, ports: Iterable[str]) -> dict[str, Difference]:
    """Return the difference of each port, in what both have of it."""
    names = list(ports)
    ours, theirs = _by_stamp(first, names), _by_stamp(second, names)
    return {
        name: _difference(ours[name], theirs[name], Decoder(first.ports[name].message_type()))
        for name in names
    }


def _by_stamp(recording: Recording, ports: Collection[str]) -> dict[str, Messages]:
    """The first message of each stamp: what follows says that nothing new has come."""
    found: dict[str, Messages] = {name: {} for name in ports}
    for message in recording.messages(ports):
        taken = split(message.data)
        found[message.port].setdefault(taken.stamp, (taken, message.data))
    return found


def _difference(ours: Messages, theirs: Messages, decoder: Decoder) -> Difference:
    both = ours.keys() & theirs.keys()
    common = [stamp for stamp in both if ours[stamp][0].valid or theirs[stamp][0].valid]
    differing = [stamp for stamp in common if ours[stamp][0].tail != theirs[stamp][0].tail]
    largest = (_largest(decoder, ours[stamp][1], theirs[stamp][1]) for stamp in differing)
    only = (
        sum(taken.valid for stamp, (taken, _) in messages.items() if stamp not in both)
        for messages in (ours, theirs)
    )
    return Difference(len(common), len(differing), max(largest, default=0.0), *only)


def _largest(decoder: Decoder, one: bytes, other: bytes) -> float:
    try:
        (a, head_a), (b, head_b) = decoder.decode(one), decoder.decode(other)
    except WireError:
        return math.inf
    if head_a[8:] != head_b[8:]:  # valid, reason, model
        return math.inf
    return max((_distance(getattr(a, f.name), getattr(b, f.name)) for f in fields(a)), default=0.0)


def _distance(one: Any, other: Any) -> float:
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        if one.shape != other.shape or one.dtype == bool:
            return 0.0 if np.array_equal(one, other) else math.inf
        return float(np.abs(one - other).max(initial=0.0))
    if isinstance(one, float) and isinstance(other, float):
        return abs(one - other)
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        return max(map(_distance, one, other), default=0.0)
    if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
        return max((_distance(one[key], other[key]) for key in one), default=0.0)
    return 0.0 if one == other else math.inf
