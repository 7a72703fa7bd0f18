"""Writes a recording: an MCAP file with the wire bytes of every message, unchanged.

Per port a channel (topic: the port's name) whose schema is what the port tells of its
type, as JSON. ``log_time`` is the arrival at the recorder and ``publish_time`` the
measurement (``acquired``), both wall time [ns]; ``sequence`` counts modulo 2^32.
Metadata carry a checksum of their own. The definition of each channel is kept twice, in
a chunk and as metadata ``channel/<id>``, so that a spoilt chunk does not cost the others.
"""

import json
import os
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from mcap.writer import CompressionType, Writer

from bus.envelope import Envelope
from bus.recording.losses import Losses
from bus.recording.sealed import seal

PROFILE = "wrenchbus"
ENCODING = "wrenchbus"  # of messages and of schemas: docs/wire.md and JSON
FLUSH = 1.0  # s at most until a message is in the file
CHUNK = 1 << 20  # bytes
CHANNEL = "channel/"


class Definition(NamedTuple):
    """What a channel carries: a port, the name and JSON description of its type, the rest."""

    topic: str
    type: str
    schema: str
    about: dict[str, str]  # JSON texts: direction, nominal_hz, owner


class RecordingWriter:
    """One file being recorded.

    Args:
        path: The file.
        about: Metadata of the whole recording: version, machine, command.
        overwrite: Whether a file that exists is replaced.
        flush: Seconds at most until a message is in the file.

    Raises:
        OSError: The file exists, or cannot be written; also from every other method.
    """

    def __init__(
        self,
        path: Path,
        about: Mapping[str, str],
        overwrite: bool = False,
        flush: float = FLUSH,
    ):
        self.path = path
        self.losses: dict[str, Losses] = {}  # by port
        self.started = time.time_ns()
        if overwrite:
            path.unlink(missing_ok=True)  # whoever reads it may go on
        self._file = path.open("xb")
        self._size = 0
        self._writer = Writer(self._file, chunk_size=CHUNK, compression=CompressionType.LZ4)
        self._schemas: dict[tuple[str, str], int] = {}
        self._channels: dict[str, int] = {}  # by definition
        self._ports: dict[int, Losses] = {}  # by channel
        self._period, self._flushed = flush, time.monotonic()
        self._writer.start(profile=PROFILE, library="wrenchbus")
        self.note("recording", {"started_ns": str(self.started), **about})

    @property
    def size(self) -> int:
        """Bytes written so far."""
        return self._size if self._file.closed else self._file.tell()

    @property
    def free(self) -> int:
        """Bytes that the file system has left for us."""
        disk = os.statvfs(self.path.parent)
        return disk.f_bavail * disk.f_frsize

    def note(self, name: str, texts: Mapping[str, str]) -> None:
        """Put metadata beside the messages."""
        self._writer.add_metadata(name, seal(name, texts))

    def attach(self, name: str, media_type: str, content: bytes) -> None:
        """Put a file beside the messages, as ``robot/icub.urdf``."""
        self._writer.add_attachment(self.started, self.started, name, media_type, content)

    def open_channel(self, name: str, info: Mapping[str, Any]) -> int:
        """Return the channel of a port; the same one when nothing has changed.

        Args:
            name: The port.
            info: What `bus.introspection.port_info` tells of it; ``type`` is needed.
        """
        schema = {key: info[key] for key in ("type", "description", "fields") if key in info}
        owner = {key: info.get("owner", {}).get(key) for key in ("service", "host")}
        about = {"nominal_hz": info.get("nominal_hz", 0.0), "owner": owner}
        about["direction"] = info.get("direction", "output")
        texts = {key: json.dumps(value, sort_keys=True) for key, value in about.items()}
        text = json.dumps(schema, sort_keys=True)
        return self.define(Definition(name, info["type"], text, texts))

    def define(self, definition: Definition) -> int:
        """Return the channel of a definition; the same one for the same definition."""
        name = definition.topic
        key = json.dumps(definition)
        if key not in self._channels:
            schema = self._schema(definition)
            channel = self._writer.register_channel(name, ENCODING, schema, definition.about)
            self._channels[key] = channel
            self._ports[channel] = self.losses.setdefault(name, Losses())
            self.note(f"{CHANNEL}{channel}", {"definition": key})
        return self._channels[key]

    def _schema(self, definition: Definition) -> int:
        key = definition.type, definition.schema
        if key not in self._schemas:
            data = definition.schema.encode()
            self._schemas[key] = self._writer.register_schema(definition.type, ENCODING, data)
        return self._schemas[key]

    def write(self, channel: int, data: bytes, envelope: Envelope, arrival: int) -> bool:
        """Append a message that arrived at a wall time [ns], unless its number does not rise."""
        if not self._ports[channel].note(envelope, self.started):
            return False
        self._writer.add_message(
            channel, arrival, data, envelope.acquired, sequence=envelope.seq & 0xFFFFFFFF
        )
        return True

    def losses_of(self, channel: int) -> Losses:
        """Return the counters of a channel's port."""
        return self._ports[channel]

    def flush(self, now: bool = False) -> None:
        """Bring what was written into the file, when it is time; or ``now``."""
        if now or time.monotonic() - self._flushed >= self._period:
            self._writer.flush()
            self._flushed = time.monotonic()

    def close(self) -> None:
        """Write what was lost, the index and the end; a file without them needs a repair."""
        try:
            for name, losses in self.losses.items():
                texts = {key: str(value) for key, value in losses.as_map().items()}
                self.note(f"losses{name}", texts)
            self._writer.finish()
            self._file.flush()
        finally:
            self.abandon()

    def abandon(self) -> None:
        """Leave the file as it is, without an end."""
        if not self._file.closed:
            self._size = self._file.tell()
            with suppress(OSError):  # of a full disk, which was told already
                self._file.close()
