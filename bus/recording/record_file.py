"""The records of an MCAP file, none trusted before its checksum; every mistake names its place."""

import os
import struct
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import NamedTuple, TypeVar

import lz4.frame
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode

from bus.recording.errors import RecordingError

T = TypeVar("T")
MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")  # opcode, length of the content
FOOTER = HEAD.size + 20
_CHUNK = struct.Struct("<QQQII")  # first and last arrival, size, checksum, length of a name
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, arrival, measurement


class Record(NamedTuple):
    """One record; ``end`` is the offset behind it."""

    opcode: int
    content: bytes
    offset: int
    end: int


class StoredMessage(NamedTuple):
    """One message of a chunk."""

    channel: int
    sequence: int
    log_time: int
    publish_time: int
    data: bytes


class RecordFile:
    """A file that is read at offsets, never beyond its end.

    Raises:
        RecordingError: The file cannot be read; also from every method, with the offset.
    """

    def __init__(self, path: Path):
        self.path = path
        try:
            self._file = path.open("rb")
            self.size = os.fstat(self._file.fileno()).st_size
        except OSError as error:
            raise RecordingError(f"{path}: {error.strerror or error}") from None

    def __enter__(self) -> "RecordFile":
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def read(self, offset: int, length: int) -> bytes:
        """Return so many bytes."""
        if not 0 <= offset <= offset + length <= self.size:
            raise RecordingError(
                f"{self.path}: spoilt at byte {offset}: {length} bytes expected there,"
                f" the file has {self.size}"
            )
        try:
            self._file.seek(offset)
            data = self._file.read(length)
        except OSError as error:
            raise RecordingError(f"{self.path}: byte {offset}: {error.strerror}") from None
        if len(data) != length:
            raise RecordingError(f"{self.path}: cut at byte {offset + len(data)} while it was read")
        return data

    def head(self, offset: int) -> tuple[int, int]:
        """Return opcode and length of the record at an offset."""
        return HEAD.unpack(self.read(offset, HEAD.size))

    def record(self, offset: int) -> Record:
        """Return the record at an offset."""
        opcode, length = self.head(offset)
        content = self.read(offset + HEAD.size, length)
        return Record(opcode, content, offset, offset + HEAD.size + length)

    @contextmanager
    def at(self, offset: int) -> Iterator[None]:
        """Turn whatever spoilt bytes lead to into an error that names the offset."""
        try:
            yield
        except RecordingError:
            raise
        except Exception as error:  # decompressors and parsers have many, of every base class
            text = " ".join(str(error).split()) or type(error).__name__
            raise RecordingError(f"{self.path}: spoilt at byte {offset}: {text}") from error


def parse(kind: Callable[[ReadDataStream], T], content: bytes) -> T:
    """Return a record of the library's from its content."""
    return kind(ReadDataStream(BytesIO(content)))


def unpack_chunk(content: bytes) -> bytes:
    """Return the records of a chunk; raise ValueError or RuntimeError when it is spoilt."""
    _, _, size, checksum, named = _CHUNK.unpack_from(content)
    begin = _CHUNK.size + named
    compression = content[_CHUNK.size : begin]
    (length,) = struct.unpack_from("<Q", content, begin)
    data = content[begin + 8 :]
    if len(data) != length:
        raise ValueError(f"a chunk of {len(data)} bytes says that it has {length}")
    plain = _decompress(compression, data)
    if len(plain) != size or zlib.crc32(plain) != checksum:
        raise ValueError("checksum of a chunk does not fit")
    return plain


def _decompress(compression: bytes, data: bytes) -> bytes:
    if compression == b"lz4":
        return lz4.frame.decompress(data)
    if compression == b"":
        return data
    raise ValueError(f"unknown compression {compression!r:.20}")


def records_in(plain: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, begin and end of the contents of a chunk's records."""
    offset = 0
    while offset < len(plain):
        opcode, length = HEAD.unpack_from(plain, offset)
        begin = offset + HEAD.size
        offset = begin + length
        if offset > len(plain):
            raise ValueError("a record reaches beyond its chunk")
        yield opcode, begin, offset


def messages_in(plain: bytes) -> Iterator[StoredMessage]:
    """Yield the messages of a chunk."""
    for opcode, begin, end in records_in(plain):
        if opcode == Opcode.MESSAGE:
            channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(plain, begin)
            data = plain[begin + _MESSAGE.size : end]
            yield StoredMessage(channel, sequence, log_time, publish_time, data)


def checked_attachment(content: bytes) -> bytes:
    """Return an attachment's content; raise ValueError when its checksum does not fit."""
    (checksum,) = struct.unpack_from("<I", content, len(content) - 4)
    if zlib.crc32(content[:-4]) != checksum:
        raise ValueError("checksum of an attachment does not fit")
    return content
