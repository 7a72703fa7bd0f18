"""What the last contact was: a short touch would be missed otherwise."""

from .touches import Alarm

APART = 0.5  # [s] of quiet after which a contact is a new one


class LastContact:
    """Remembers the most probable reading of the last contact."""

    def __init__(self) -> None:
        self._best: Alarm | None = None
        self._seen = 0.0  # [s]

    def note(self, alarm: Alarm, now: float) -> None:
        """Take in the alarm line of the moment ``now`` [s]."""
        if not alarm.contact:
            return
        is_new = self._best is None or now - self._seen > APART
        if is_new or self._best is None or alarm.probability >= self._best.probability:
            self._best = alarm
        self._seen = now

    def text(self, now: float) -> str:
        """Return the line that the page shows."""
        if self._best is None:
            return "last contact: none since this page started"
        label = self._best.text.removeprefix("contact: ")
        return f"last contact: {label}, {now - self._seen:.0f} s ago"
