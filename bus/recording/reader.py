"""Reads a recording; of one that was cut, all that is whole."""

import json
import struct
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import IO, Any, NamedTuple

from mcap.exceptions import McapError
from mcap.reader import McapReader, make_reader
from mcap.records import Channel, Schema
from mcap.summary import Summary

from bus.described_type import build
from bus.envelope import Envelope, envelope_of
from bus.errors import BusError


MessageType = type


class RecordingError(BusError):
    """A file is no recording, or spoilt at a place that the text names."""


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
        RecordingError: The file is missing, no recording, cut, or spoilt.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        with self._opened() as reader:
            header = reader.get_header()
            if header.profile != "wrenchbus":
                raise RecordingError(f"{path}: an MCAP file of another program ({header.profile})")
            summary = reader.get_summary()
        if summary is None or summary.statistics is None:
            raise RecordingError(
                f"{path}: not finished; wrenchbus log repair rescues what is there"
            )
        self._summary: Summary = summary
        counts = summary.statistics.channel_message_counts
        self._counts = {id_: counts.get(id_, 0) for id_ in summary.channels}
        self.start: int = summary.statistics.message_start_time  # arrival, wall time [ns]
        self.end: int = summary.statistics.message_end_time

    @cached_property
    def ports(self) -> dict[str, Port]:
        """The recorded ports by name, sorted."""
        found: dict[str, Port] = {}
        for id_, channel in self._summary.channels.items():
            port = _port(channel, self._summary.schemas[channel.schema_id], self._counts[id_])
            earlier = found.get(port.name)
            found[port.name] = port._replace(count=port.count + (earlier.count if earlier else 0))
        return dict(sorted(found.items()))

    @cached_property
    def metadata(self) -> dict[str, dict[str, str]]:
        """What the recorder noted: ``recording``, and ``losses/<port>`` for each port."""
        with self._opened() as reader:
            return {record.name: record.metadata for record in reader.iter_metadata()}

    @cached_property
    def attachments(self) -> dict[str, bytes]:
        """The files beside the messages, by name."""
        with self._opened() as reader:
            return {item.name: item.data for item in reader.iter_attachments()}

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
        with self._opened() as reader:
            topics = None if ports is None else list(ports)
            found = reader.iter_messages(topics, starting_at=start, ending_before=end)
            for _, channel, message in found:
                yield Message(channel.topic, message.data, message.log_time)

    @contextmanager
    def _opened(self) -> Iterator[McapReader]:
        try:
            with self.path.open("rb") as file:
                yield make_reader(file, validate_crcs=True)
        except OSError as error:
            raise RecordingError(f"{self.path}: {error.strerror or error}") from None
        except (McapError, ValueError, struct.error, KeyError, EOFError) as error:
            raise RecordingError(f"{self.path}: spoilt: {error}") from error


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


def rescue(file: IO[bytes]) -> Iterator[Any]:
    """Yield the records of a file up to the first that is cut or spoilt, chunks whole."""
    from mcap.stream_reader import StreamReader

    try:
        yield from StreamReader(file, emit_chunks=True, validate_crcs=True).records
    except (McapError, ValueError, struct.error, KeyError, EOFError):
        return
