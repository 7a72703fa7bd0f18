"""Renews what `test_replay` expects: ``python -m tests.system.record_reference [--new]``.

Without ``--new`` the kept raw frames are replayed and the estimates of today become the
reference; with it the raw frames are recorded anew from the plant.
"""

import sys
import tempfile
from pathlib import Path

from bus.envelope import envelope_of
from bus.recording import Recording, RecordingWriter
from bus.recording.heads import head_of, join, split
from robot_model import load_robot, ports
from tests.system.lockstep_runs import REFERENCE, machine, outputs, record_live, record_replay

TICKS = 480
EVERY = 4_000_000  # ns between kept estimates of 1 kHz; all would be too many bytes
FAST = 250.0  # Hz
SOON = 1_000_000  # ns
MOST = 2_000_000  # bytes


def main(new: bool) -> None:
    """Write the reference."""
    robot = load_robot("icub")
    raw = ports.name("raw", robot)
    with tempfile.TemporaryDirectory() as folder:
        frames = REFERENCE
        if new:
            frames = Path(folder) / "live.mcap"
            record_live(robot, frames, TICKS)
        estimates = record_replay(robot, frames, Path(folder) / "replay.mcap")
        kept = Path(folder) / "kept.mcap"
        _write(kept, Recording(frames), estimates, raw, outputs(robot))
        size = kept.stat().st_size
        if size > MOST:
            raise SystemExit(f"{size} bytes are more than {MOST}")
        REFERENCE.parent.mkdir(exist_ok=True)
        REFERENCE.write_bytes(kept.read_bytes())
    print(f"{REFERENCE}: {size} bytes")


def _write(path: Path, frames: Recording, estimates: Recording, raw: str, names: list[str]) -> None:
    """Write all raw frames, and the valid estimates, some of those that are frequent."""
    writer = RecordingWriter(path, machine())
    sent_at = {split(m.data).stamp: split(m.data).sent for m in frames.messages([raw])}
    _copy(writer, frames, raw, {})
    for name in names:
        _copy(writer, estimates, name, sent_at)
    writer.close()


def _copy(
    writer: RecordingWriter, recording: Recording, name: str, sent_at: dict[int, int]
) -> None:
    """Copy a port; estimates as if sent soon after the frame of their stamp [ns]."""
    port = recording.ports[name]
    told = {"type": port.type, "fields": port.fields, "nominal_hz": port.nominal_hz}
    channel = writer.open_channel(name, told)
    every = EVERY if sent_at and port.nominal_hz > FAST else 1
    for message in recording.messages([name]):
        data, envelope = message.data, envelope_of(message.data)
        if sent_at and (not envelope.valid or envelope.stamp % every or envelope.stamp == 0):
            continue
        if sent_at:
            data = _sent(data, sent_at[envelope.stamp] + SOON)
            envelope = envelope_of(data)
        writer.write(channel, data, envelope, envelope.sent + SOON)


def _sent(data: bytes, sent: int) -> bytes:
    """Return a message as sent at another time."""
    taken, head = split(data), envelope_of(data)
    prefix = head_of(head.type, head.source, head.epoch)
    return join(prefix, head.seq, *taken[:3], sent, taken.tail)


if __name__ == "__main__":
    main("--new" in sys.argv[1:])
