"""How a recording begins and ends: its header, and the index of a finished one."""

import zlib
from io import BytesIO

from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    ChunkIndex,
    Footer,
    Header,
    MetadataIndex,
    Schema,
    Statistics,
)
from mcap.stream_reader import StreamReader
from mcap.summary import Summary

from bus.recording.errors import RecordingError
from bus.recording.record_file import FOOTER, MAGIC, RecordFile, parse
from bus.recording.writer import PROFILE


def check_header(file: RecordFile) -> None:
    """Raise RecordingError when a file does not begin as a recording does."""
    if file.size < len(MAGIC) or file.read(0, len(MAGIC)) != MAGIC:
        raise RecordingError(f"{file.path}: not an MCAP file, at byte 0")
    with file.at(len(MAGIC)):
        record = file.record(len(MAGIC))
        if record.opcode != Opcode.HEADER:
            raise ValueError(f"expected the header, got a record {record.opcode}")
        profile = parse(Header.read, record.content).profile
    if profile != PROFILE:
        raise RecordingError(f"{file.path}: an MCAP file of another program ({profile!r:.40})")


def read_summary(file: RecordFile) -> Summary:
    """Return the index at the end of a file, when it is whole."""
    end = file.size - len(MAGIC)
    if end < FOOTER or file.read(end, len(MAGIC)) != MAGIC:
        raise RecordingError(
            f"{file.path}: not finished, cut at byte {file.size};"
            " wrenchbus log repair rescues what is there"
        )
    offset = end - FOOTER
    with file.at(offset):
        record = file.record(offset)
        footer = parse(Footer.read, record.content)
        if record.opcode != Opcode.FOOTER or record.end != end or not footer.summary_start:
            raise ValueError("no footer, or no index before it")
    with file.at(footer.summary_start):
        index = file.read(footer.summary_start, end - footer.summary_start)
        if zlib.crc32(index[:-4]) != footer.summary_crc:
            raise ValueError("checksum of the index does not fit")
        summary = _summary_of(index)
        if summary.statistics is None:
            raise ValueError("the index has no statistics")
    return summary


def _summary_of(index: bytes) -> Summary:
    summary = Summary()
    for record in StreamReader(BytesIO(index + MAGIC), skip_magic=True).records:
        match record:
            case Statistics():
                summary.statistics = record
            case Schema():
                summary.schemas[record.id] = record
            case Channel():
                summary.channels[record.id] = record
            case AttachmentIndex():
                summary.attachment_indexes.append(record)
            case ChunkIndex():
                summary.chunk_indexes.append(record)
            case MetadataIndex():
                summary.metadata_indexes.append(record)
    return summary
