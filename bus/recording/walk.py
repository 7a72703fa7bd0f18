"""Goes through a file that may be spoilt anywhere, from one whole record to the next."""

import re
import struct
from collections.abc import Iterator
from typing import NamedTuple

from mcap.opcode import Opcode
from mcap.records import Attachment, Metadata

from bus.recording.errors import RecordingError
from bus.recording.record_file import (
    HEAD,
    MAGIC,
    Record,
    RecordFile,
    checked_attachment,
    parse,
    records_in,
    unpack_chunk,
)
from bus.recording.sealed import unseal

COMPRESSION = b"\x03\x00\x00\x00lz4"  # in a chunk's head; it is what a search can look for
BEFORE = HEAD.size + 28  # bytes of a chunk before that
WINDOW = 1 << 20  # bytes
DATA = {Opcode.HEADER, Opcode.CHUNK, Opcode.MESSAGE_INDEX, Opcode.METADATA, Opcode.ATTACHMENT}
NOT_DATA = set(Opcode) - DATA  # the end of the data, and the index


class GivenUp(NamedTuple):
    """Bytes of a file that are no whole record."""

    start: int
    end: int
    reason: str


def walk(file: RecordFile) -> Iterator[Record | GivenUp]:
    """Yield the whole records of a file, and the bytes between them that are none."""
    offset, end = len(MAGIC), file.size
    finished = end >= 2 * len(MAGIC) and file.read(end - len(MAGIC), len(MAGIC)) == MAGIC
    end -= len(MAGIC) if finished else 0
    indexed = False  # beyond the data
    while offset < end:
        try:
            record = _checked(file, offset, indexed)
        except RecordingError as error:
            after = _next_record(file, offset, end)
            yield GivenUp(offset, after, _reason(file, error))
            offset = after
            continue
        indexed = record.opcode in NOT_DATA
        yield record
        offset = record.end


def _reason(file: RecordFile, error: RecordingError) -> str:
    return re.sub(r"^spoilt at byte \d+: ", "", str(error).removeprefix(f"{file.path}: "))


def _checked(file: RecordFile, offset: int, indexed: bool) -> Record:
    """Return a record whose checksum fits; raise RecordingError for any other."""
    with file.at(offset):
        record = file.record(offset)
        _check(record, indexed)
    return record


def _check(record: Record, indexed: bool) -> None:
    content = record.content
    match record.opcode:
        case Opcode.CHUNK:
            for _ in records_in(unpack_chunk(content)):
                pass
        case Opcode.METADATA:
            unseal(parse(Metadata.read, content))
        case Opcode.ATTACHMENT:
            parse(Attachment.read, checked_attachment(content))
        case Opcode.MESSAGE_INDEX:
            if len(content) < 6 or struct.unpack_from("<I", content, 2)[0] != len(content) - 6:
                raise ValueError("the index of a chunk has another length than it says")
        case Opcode.HEADER if record.offset == len(MAGIC):
            pass
        case Opcode.DATA_END if len(content) == 4:
            pass
        case _ if not indexed or record.opcode not in NOT_DATA:
            raise ValueError(f"no record of a recording (opcode {record.opcode})")


def _next_record(file: RecordFile, offset: int, end: int) -> int:
    """Return where to go on behind a spoilt record: at the next record or whole chunk."""
    found = _next_chunk(file, offset + 1, end)
    try:
        _, length = file.head(offset)
        after = offset + HEAD.size + length
        opcode, length = file.head(after)
    except (RecordingError, struct.error):
        return found
    plausible = opcode in set(Opcode) and after + HEAD.size + length <= end
    return min(after, found) if plausible else found


def _next_chunk(file: RecordFile, offset: int, end: int) -> int:
    """Return the offset of the next chunk that is whole, or the end."""
    position = offset + BEFORE
    while position < end:
        window = file.read(position, min(WINDOW + len(COMPRESSION), end - position))
        found = window.find(COMPRESSION)
        while found >= 0:
            start = position + found - BEFORE
            if _is_chunk(file, start):
                return start
            found = window.find(COMPRESSION, found + 1)
        position += WINDOW
    return end


def _is_chunk(file: RecordFile, offset: int) -> bool:
    try:
        if file.head(offset)[0] != Opcode.CHUNK:
            return False
        _checked(file, offset, False)
    except RecordingError:
        return False
    return True
