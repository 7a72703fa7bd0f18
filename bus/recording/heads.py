"""The head of a recorded message: read, and replaced by that of who plays it."""

from typing import NamedTuple

from bus.envelope import Envelope, envelope_of
from bus.head import ARRAY_OF_14, INT64, NUMBERS, TAGS, UINT32, UINT64, pack_prefix
from bus.packing import pack, unpack

SOURCE, EPOCH = 18, 5  # bytes on the wire, tags included
TRUE, TEXT_8 = 0xC3, 0xD9


class Recorded(NamedTuple):
    """A message without what belongs to its writer: type, source, epoch, sequence number."""

    stamp: int  # ns
    clock: int
    acquired: int  # wall ns
    sent: int  # wall ns
    valid: bool
    tail: bytes  # from ``valid`` on, unchanged
    type: str


def split(data: bytes) -> Recorded:
    """Take a message apart; raise WireError when it is none."""
    start = _numbers_at(data)
    if start:
        numbers = NUMBERS.unpack_from(data, start)
        tag_seq, _, tag_stamp, stamp, clock, tag_acquired, acquired, tag_sent, sent = numbers
        if (tag_seq, tag_stamp, tag_acquired, tag_sent) == TAGS and clock <= 1:
            end = start + NUMBERS.size
            name = data[2 + (data[1] == TEXT_8) : start - SOURCE - EPOCH].decode(errors="replace")
            return Recorded(stamp, clock, acquired, sent, data[end] == TRUE, data[end:], name)
    return _split(data)


def join(prefix: bytes, seq: int, stamp: int, clock: int, acquired: int, sent: int, tail: bytes):
    """Return a message with another head; ``prefix`` is that of `head_of`."""
    numbers = NUMBERS.pack(UINT64, seq, INT64, stamp, clock, INT64, acquired, INT64, sent)
    return b"".join((prefix, numbers, tail))


def head_of(type_name: str, source: bytes, epoch: int) -> bytes:
    """Return the part that all messages of one writer begin with."""
    return pack_prefix(type_name, source, epoch)


def _numbers_at(data: bytes) -> int:
    """Where the numbers of the usual form begin; 0 when it is not the usual form."""
    if len(data) < 64 or data[0] != ARRAY_OF_14:
        return 0
    if 0xA0 <= data[1] < 0xC0:  # a short text
        after_type = 2 + (data[1] & 0x1F)
    elif data[1] == TEXT_8:
        after_type = 3 + data[2]
    else:
        return 0
    start = after_type + SOURCE + EPOCH
    usual = data[after_type : after_type + 2] == b"\xc4\x10" and len(data) > start + NUMBERS.size
    return start if usual and data[start - EPOCH] == UINT32 else 0


def _split(data: bytes) -> Recorded:
    """Take apart what another encoder has written."""
    envelope: Envelope = envelope_of(data)
    tail = b"".join(pack(part) for part in unpack(data)[8:])
    stamp, clock, acquired, sent, valid = envelope[4:9]
    return Recorded(stamp, clock, acquired, sent, valid, tail, envelope.type)
