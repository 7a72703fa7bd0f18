"""The fixed part of a message: everything up to ``sent`` has one width for one source.

``0x9e, type, source, uint32 epoch`` is the same in all messages of a source; then
come seq (uint64), stamp (int64), clock (one digit), acquired, sent (int64), each with
its MessagePack tag. A reader that finds this form need not parse it.
"""

import struct

from bus.packing import pack

ARRAY_OF_14, UINT32, UINT64, INT64 = 0x9E, 0xCE, 0xCF, 0xD3
NUMBERS = struct.Struct(">BQBqBBqBq")  # tag seq tag stamp clock tag acquired tag sent
TAGS = (UINT64, INT64, INT64, INT64)


def pack_prefix(type_name: str, source: bytes, epoch: int) -> bytes:
    """Return the part that all messages of one source begin with."""
    packed = pack(type_name) + pack(source)
    return bytes((ARRAY_OF_14,)) + packed + struct.pack(">BI", UINT32, epoch)


def pack_block_head(size: int) -> bytes:
    """Return the MessagePack header of a block of ``size`` bytes."""
    if size < 1 << 8:
        return struct.pack(">BB", 0xC4, size)
    if size < 1 << 16:
        return struct.pack(">BH", 0xC5, size)
    return struct.pack(">BI", 0xC6, size)
