"""Writes a recording: an MCAP file with the wire bytes of every message, unchanged.

Per port a channel (topic: the port's name) whose schema is what the port tells of its
type, as JSON. ``log_time`` is the arrival at the recorder and ``publish_time`` the
measurement (``acquired``), both wall time [ns]; ``sequence`` counts modulo 2^32.
"""

import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from bus.envelope import Envelope
from bus.recording.losses import Losses

PROFILE = "wrenchbus"
ENCODING = "wrenchbus"  # of messages and of schemas: docs/wire.md and JSON
FLUSH = 1.0  # s at most until a message is in the file
CHUNK = 1 << 20  # bytes


class RecordingWriter:
    """One file being recorded.

    Args:
        path: The file; one that exists is written over.
        about: Metadata of the whole recording: version, machine, command.

    Raises:
        OSError: The file cannot be written; also from every other method.
    """

    def __init__(self, path: Path, about: Mapping[str, str]):
        self.path = path
        self.losses: dict[str, Losses] = {}  # by port
        self.started = time.time_ns()
        self._file = path.open("wb")
        self._writer = Writer(self._file, chunk_size=CHUNK, compression=CompressionType.LZ4)
        self._writer.start(profile=PROFILE, library="wrenchbus")
        self._writer.add_metadata("recording", {"started_ns": str(self.started), **about})
        self._schemas: dict[str, int] = {}
        self._flushed = time.monotonic()

    @property
    def size(self) -> int:
        """Bytes written so far."""
        return self._file.tell()

    def attach(self, name: str, media_type: str, content: bytes) -> None:
        """Put a file beside the messages, as ``robot/icub.urdf``."""
        self._writer.add_attachment(self.started, self.started, name, media_type, content)

    def open_channel(self, name: str, info: Mapping[str, Any]) -> int:
        """Return the channel of a port.

        Args:
            name: The port.
            info: What `bus.introspection.port_info` tells of it; ``type`` is needed.
        """
        schema = {key: info[key] for key in ("type", "description", "fields") if key in info}
        text = json.dumps(schema, sort_keys=True)
        if text not in self._schemas:
            data = text.encode()
            self._schemas[text] = self._writer.register_schema(info["type"], ENCODING, data)
        self.losses.setdefault(name, Losses())
        about = {"nominal_hz": info.get("nominal_hz", 0.0), "owner": info.get("owner", {})}
        about["direction"] = info.get("direction", "output")
        texts = {key: json.dumps(value) for key, value in about.items()}
        return self._writer.register_channel(name, ENCODING, self._schemas[text], texts)

    def write(self, channel: int, data: bytes, envelope: Envelope, arrival: int) -> None:
        """Append a message that arrived at a wall time [ns]."""
        self._writer.add_message(
            channel, arrival, data, envelope.acquired, sequence=envelope.seq & 0xFFFFFFFF
        )

    def flush(self, now: bool = False) -> None:
        """Bring what was written into the file, when a second has passed; or ``now``."""
        if now or time.monotonic() - self._flushed >= FLUSH:
            self._writer.flush()
            self._flushed = time.monotonic()

    def close(self) -> None:
        """Write what was lost, the index and the end; a file without them needs a repair."""
        try:
            for name, losses in self.losses.items():
                self._writer.add_metadata(f"losses{name}", losses.as_texts())
            self._writer.finish()
        finally:
            self._file.close()
