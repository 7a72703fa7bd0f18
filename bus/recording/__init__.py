"""Recordings: what was on the bus, byte for byte, in an MCAP file."""

from bus.recording.errors import RecordingError
from bus.recording.reader import Message, Port, Recording
from bus.recording.writer import RecordingWriter

__all__ = ["Message", "Port", "Recording", "RecordingError", "RecordingWriter"]
