"""Rescues what is whole in a recording that was cut or spoilt."""

import json
from dataclasses import dataclass, field
from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Metadata, Schema

from bus.envelope import envelope_of
from bus.errors import WireError
from bus.recording.errors import RecordingError
from bus.recording.index import check_header, read_summary
from bus.recording.record_file import (
    Record,
    RecordFile,
    StoredMessage,
    messages_in,
    parse,
    records_in,
    unpack_chunk,
)
from bus.recording.sealed import unseal
from bus.recording.walk import GivenUp, walk
from bus.recording.writer import CHANNEL, Definition, RecordingWriter


@dataclass
class Repair:
    """What was rescued."""

    messages: int = 0
    ports: int = 0
    seconds: float = 0.0  # from the first arrival to the last
    given_up: list[GivenUp] = field(default_factory=list)
    nameless: int = 0  # messages of channels whose definition is lost
    missing: int | None = None  # messages that the file's own index knows besides

    @property
    def whole(self) -> bool:
        """Whether nothing was wrong."""
        return not (self.given_up or self.nameless or self.missing)


def repair(path: Path, new: Path, overwrite: bool = False) -> Repair:
    """Write all that is whole in a recording into a new one; return what was rescued.

    Raises:
        RecordingError: The file is no recording or nothing in it is whole, or the new one
            cannot be written.
    """
    with RecordFile(path) as file:
        source = _Source(file)
        if not source.chunks and not source.metadata:
            raise RecordingError(f"{path}: nothing to rescue: {source.complaint()}")
        try:
            return _write(source, new, overwrite)
        except OSError as error:
            raise RecordingError(f"{new}: {error.strerror or error}") from None


class _Source:
    """What is whole in a file, found in one pass."""

    def __init__(self, file: RecordFile):
        self.file = file
        self.chunks: list[int] = []  # offsets
        self.attachments: list[int] = []
        self.metadata: dict[str, dict[str, str]] = {}
        self.channels: dict[int, Definition] = {}
        self.given_up: list[GivenUp] = []
        self.counted: int | None = None
        self._check_profile()
        for found in walk(file):
            if isinstance(found, GivenUp):
                self.given_up.append(found)
            else:
                self._note(found)
        self._read_index()

    def complaint(self) -> str:
        """Say what is wrong first."""
        first = next(iter(self.given_up), None)
        return f"at byte {first.start}: {first.reason}" if first else "it holds no record"

    def _check_profile(self) -> None:
        """Refuse what is whole and no recording; a spoilt header is no reason to give up."""
        try:
            check_header(self.file)
        except RecordingError as error:
            if "spoilt" not in str(error):
                raise

    def _note(self, record: Record) -> None:
        match record.opcode:
            case Opcode.CHUNK:
                self.chunks.append(record.offset)
                self._note_channels(unpack_chunk(record.content))
            case Opcode.ATTACHMENT:
                self.attachments.append(record.offset)
            case Opcode.METADATA:
                metadata = parse(Metadata.read, record.content)
                self._note_metadata(metadata.name, unseal(metadata))

    def _note_metadata(self, name: str, texts: dict[str, str]) -> None:
        if name.startswith(CHANNEL):
            definition = Definition(*json.loads(texts["definition"]))
            self.channels[int(name.removeprefix(CHANNEL))] = definition
        else:
            self.metadata[name] = texts

    def _note_channels(self, plain: bytes) -> None:
        schemas: dict[int, Schema] = {}
        for opcode, begin, end in records_in(plain):
            if opcode == Opcode.SCHEMA:
                schema = parse(Schema.read, plain[begin:end])
                schemas[schema.id] = schema
            elif opcode == Opcode.CHANNEL:
                channel = parse(Channel.read, plain[begin:end])
                if channel.schema_id in schemas:
                    self.channels[channel.id] = _definition(channel, schemas[channel.schema_id])

    def _read_index(self) -> None:
        try:
            summary = read_summary(self.file)
        except RecordingError:
            return
        self.counted = summary.statistics.message_count if summary.statistics else None
        for id_, channel in summary.channels.items():
            if channel.schema_id in summary.schemas:
                known = _definition(channel, summary.schemas[channel.schema_id])
                self.channels.setdefault(id_, known)


def _definition(channel: Channel, schema: Schema) -> Definition:
    return Definition(channel.topic, schema.name, schema.data.decode(), channel.metadata)


def _write(source: _Source, new: Path, overwrite: bool) -> Repair:
    done = Repair(given_up=source.given_up)
    about = source.metadata.pop("recording", {})
    with_source = {**about, "repaired_from": source.file.path.name}
    if overwrite and new.exists() and new.samefile(source.file.path):
        raise RecordingError(f"{new}: a recording is not repaired into itself")
    writer = RecordingWriter(new, with_source, overwrite)
    writer.started = int(about.get("started_ns", writer.started))
    try:
        _copy(source, writer, done)
        writer.note("repair", _told(done))
        writer.close()
    finally:
        writer.abandon()
    return done


def _copy(source: _Source, writer: RecordingWriter, done: Repair) -> None:
    file, first, last = source.file, 0, 0
    for name, texts in source.metadata.items():
        if not name.startswith(("losses/", "repair")):  # told anew
            writer.note(name, texts)
    for offset in source.attachments:
        item = parse(Attachment.read, file.record(offset).content)
        writer.attach(item.name, item.media_type, item.data)
    channels = {id_: writer.define(known) for id_, known in source.channels.items()}
    for offset in source.chunks:
        for message in messages_in(unpack_chunk(file.record(offset).content)):
            channel = channels.get(message.channel)
            if channel is None:
                done.nameless += 1
                continue
            first, last = first or message.log_time, message.log_time
            done.messages += _copied(writer, channel, message)
        writer.flush()
    done.ports = sum(losses.recorded > 0 for losses in writer.losses.values())
    done.seconds = (last - first) * 1e-9
    if source.counted is not None:
        done.missing = max(source.counted - done.messages - done.nameless, 0)


def _copied(writer: RecordingWriter, channel: int, message: StoredMessage) -> bool:
    try:
        envelope = envelope_of(message.data)
    except WireError:  # recorded as it was
        writer.losses_of(channel).refused += 1
        return False
    return writer.write(channel, message.data, envelope, message.log_time)


def _told(done: Repair) -> dict[str, str]:
    given_up = [entry._asdict() for entry in done.given_up]
    return {
        "messages": str(done.messages),
        "given_up": json.dumps(given_up),
        "nameless": str(done.nameless),
    }
