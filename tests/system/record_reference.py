"""Renews what `test_replay` expects: ``python -m tests.system.record_reference [--new]``.

Without ``--new`` the kept raw frames are replayed and the estimates of today become the
reference; with it the raw frames are recorded anew from the plant.
"""

import sys
import tempfile
from pathlib import Path

from bus.envelope import envelope_of
from bus.recording import Recording, RecordingWriter
from robot_model import load_robot, ports
from tests.system.lockstep_runs import REFERENCE, machine, outputs, record_live, record_replay

TICKS = 480
EVERY = 4_000_000  # ns between kept estimates of 1 kHz; all would be too many bytes
FAST = 250.0  # Hz
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
    for recording, name in [(frames, raw), *((estimates, name) for name in names)]:
        port = recording.ports[name]
        told = {"type": port.type, "fields": port.fields, "nominal_hz": port.nominal_hz}
        channel = writer.open_channel(name, told)
        every = EVERY if name != raw and port.nominal_hz > FAST else 1
        for message in recording.messages([name]):
            envelope = envelope_of(message.data)
            if name == raw or (envelope.valid and envelope.stamp % every == 0):
                writer.write(channel, message.data, envelope, message.arrival)
    writer.close()


if __name__ == "__main__":
    main("--new" in sys.argv[1:])
