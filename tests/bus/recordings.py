"""Small recordings for the tests."""

from pathlib import Path

from bus.encoder import Encoder
from bus.envelope import envelope_of, new_source
from bus.recording import RecordingWriter
from bus.schema import fields_of
from tests.bus.messages import Number

SECOND = 1_000_000_000  # ns
INFO = {
    "type": "Number/1",
    "direction": "output",
    "nominal_hz": 100.0,
    "fields": [field.describe() for field in fields_of(Number)],
}


class Source:
    """An opening of a port, whose messages count."""

    def __init__(self) -> None:
        self._encoder = Encoder(Number, new_source())
        self.seq = 0

    def message(self, value: float | None = None, skip: int = 0) -> bytes:
        """Return the next message; ``skip`` of them are never seen."""
        self.seq += 1 + skip
        times = self.seq, 1, self.seq, self.seq
        number = Number(value=float(self.seq if value is None else value))
        return self._encoder.encode(number, self.seq, *times, True, "")


def record(writer: RecordingWriter, channel: int, data: bytes, at: int) -> None:
    """Write a message that arrived at a time [ns]."""
    writer.write(channel, data, envelope_of(data), at)


def make(path: Path, ports: tuple[str, ...] = ("/a:o", "/b:o"), chunks: int = 6, each: int = 8):
    """Write a recording of several chunks; return it with no name for its messages."""
    writer = RecordingWriter(path, {"version": "1"})
    sources = {name: Source() for name in ports}
    channels = {name: writer.open_channel(name, INFO) for name in ports}
    writer.attach("config/a.json", "application/json", b'{"gain": 1.5}')
    for chunk in range(chunks):
        for k in range(each):
            for name in ports:
                at = SECOND * (1 + chunk) + k
                record(writer, channels[name], sources[name].message(), at)
        writer.flush(now=True)
    writer.close()
