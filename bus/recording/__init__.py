"""Recordings: what was on the bus, byte for byte, in an MCAP file."""

from bus.recording.reader import Message, Port, Recording, RecordingError
from bus.recording.writer import RecordingWriter

__all__ = ["Message", "Port", "Recording", "RecordingError", "RecordingWriter"]
