"""What is wrong with a recording."""

from bus.errors import BusError


class RecordingError(BusError):
    """A file is no recording, or spoilt at a place that the text names."""
