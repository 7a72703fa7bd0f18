"""Reads a finished recording: all that it yields has passed a checksum."""

import json
from collections.abc import Collection, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, ChunkIndex, Metadata, Schema
from mcap.summary import Summary

from bus.described_type import build
from bus.envelope import Envelope, envelope_of
from bus.recording.errors import RecordingError
from bus.recording.index import check_header, read_summary
from bus.recording.record_file import (
    FOOTER,
    RecordFile,
    StoredMessage,
    checked_attachment,
    messages_in,
    parse,
    unpack_chunk,
)
from bus.recording.sealed import unseal
from bus.recording.writer import CHANNEL

MessageType = type


class Port(NamedTuple):
    """A recorded port."""

    name: str
    type: str
    direction: str  # output, or input for what was written to it directly
    nominal_hz: float
    fields: list[dict[str, Any]]  # as `bus.introspection.port_info` tells them
    count: int  # messages

    def message_type(self) -> MessageType:
        """Return a dataclass for the port's messages, for a `bus.decoder.Decoder`."""
        return build(self.type, self.fields)


class Message(NamedTuple):
    """One recorded message: its wire bytes, and its arrival at the recorder, wall time [ns]."""

    port: str
    data: bytes
    arrival: int

    @property
    def envelope(self) -> Envelope:
        """The message's envelope; raises WireError when the bytes are no message."""
        return envelope_of(self.data)


class Recording:
    """A finished recording.

    Raises:
        RecordingError: The file is missing, no recording, cut, or spoilt; the text says
            where. Also from everything that reads on.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        with RecordFile(self.path) as file:
            check_header(file)
            self._summary = read_summary(file)
            with file.at(file.size - FOOTER):
                self.channels = _ports_of(self._summary)  # anew where type or owner changed
        statistics = self._summary.statistics
        assert statistics is not None
        self.start: int = statistics.message_start_time  # arrival, wall time [ns]
        self.end: int = statistics.message_end_time

    @cached_property
    def ports(self) -> dict[str, Port]:
        """The recorded ports by name, sorted; of one whose type changed, the last type."""
        found: dict[str, Port] = {}
        for port in self.channels:
            earlier = found.get(port.name)
            found[port.name] = port._replace(count=port.count + (earlier.count if earlier else 0))
        return dict(sorted(found.items()))

    @cached_property
    def metadata(self) -> dict[str, dict[str, str]]:
        """What the recorder noted: ``recording``, and ``losses/<port>`` for each port."""
        found: dict[str, dict[str, str]] = {}
        with RecordFile(self.path) as file:
            for index in self._summary.metadata_indexes:
                with file.at(index.offset):
                    record = parse(Metadata.read, file.record(index.offset).content)
                    found[record.name] = unseal(record)
        return {name: texts for name, texts in found.items() if not name.startswith(CHANNEL)}

    @cached_property
    def attachments(self) -> dict[str, bytes]:
        """The files beside the messages, by name."""
        found: dict[str, bytes] = {}
        with RecordFile(self.path) as file:
            for index in self._summary.attachment_indexes:
                with file.at(index.offset):
                    content = checked_attachment(file.record(index.offset).content)
                    found[index.name] = parse(Attachment.read, content).data
        return found

    def messages(
        self,
        ports: Collection[str] | None = None,
        start: int | None = None,
        end: int | None = None,
    ) -> Iterator[Message]:
        """Yield the messages of some ports (all by default) in order of arrival.

        Args:
            start: First arrival, wall time [ns].
            end: Arrival before which to stop.
        """
        if missing := set(ports or ()) - self.ports.keys():
            raise RecordingError(f"{self.path}: no {sorted(missing)}; it has {sorted(self.ports)}")
        topics = {
            id_: channel.topic
            for id_, channel in self._summary.channels.items()
            if ports is None or channel.topic in ports
        }
        first = self.start if start is None else start
        last = self.end + 1 if end is None else end
        for message in self._stored(topics, first, last):
            if first <= message.log_time < last and message.channel in topics:
                yield Message(topics[message.channel], message.data, message.log_time)

    def _stored(self, topics: Collection[int], first: int, last: int) -> Iterator[StoredMessage]:
        """Yield messages in order of arrival, holding back those that a later chunk precedes."""
        chunks = [
            index
            for index in sorted(self._summary.chunk_indexes, key=lambda i: i.message_start_time)
            if index.message_end_time >= first
            and index.message_start_time < last
            and not _lacks(index, topics)
        ]
        waiting: list[StoredMessage] = []
        with RecordFile(self.path) as file:
            for index in chunks:
                if waiting and waiting[-1].log_time >= index.message_start_time:
                    early = [m for m in waiting if m.log_time < index.message_start_time]
                    yield from early
                    waiting = waiting[len(early) :]
                else:
                    yield from waiting
                    waiting = []
                waiting += self._chunk(file, index)
                waiting.sort(key=lambda message: message.log_time)
            yield from waiting

    def _chunk(self, file: RecordFile, index: ChunkIndex) -> list[StoredMessage]:
        with file.at(index.chunk_start_offset):
            record = file.record(index.chunk_start_offset)
            if record.opcode != Opcode.CHUNK:
                raise ValueError(f"expected a chunk, got a record {record.opcode}")
            return list(messages_in(unpack_chunk(record.content)))


def _lacks(chunk: ChunkIndex, channels: Collection[int]) -> bool:
    told = chunk.message_index_offsets.keys()
    return bool(told) and told.isdisjoint(channels)


def _ports_of(summary: Summary) -> list[Port]:
    counts = summary.statistics.channel_message_counts if summary.statistics else {}
    return [
        _port(channel, summary.schemas[channel.schema_id], counts.get(id_, 0))
        for id_, channel in summary.channels.items()
    ]


def _port(channel: Channel, schema: Schema, count: int) -> Port:
    told = json.loads(schema.data)
    about = {key: json.loads(text) for key, text in channel.metadata.items()}
    return Port(
        channel.topic,
        schema.name,
        about.get("direction", "output"),
        about.get("nominal_hz", 0.0),
        told.get("fields", []),
        count,
    )
