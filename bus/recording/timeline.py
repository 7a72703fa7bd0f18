"""When a moment of a recording is due: a schedule that does not drift."""

MOST_BEHIND = 1_000_000_000  # ns that are caught up with after a stall; more is given up


class Timeline:
    """Maps times of a recording to the monotonic clock, both in ns; pausable, at a rate.

    Everything is due at a time that follows from one pair of times, so errors do not add
    up; the pair changes with pauses, rates and jumps only.

    Attributes:
        slipped: Time of the recording [ns] that came late because the machine stalled.
    """

    def __init__(self, start: int, rate: float = 1.0):
        self.rate = rate
        self.paused = True
        self.slipped = 0
        self._at, self._since = start, 0

    def position(self, now: int) -> int:
        """Return the time of the recording at a monotonic time."""
        if self.paused:
            return self._at
        return self._at + round((now - self._since) * self.rate)

    def remaining(self, moment: int, now: int) -> int:
        """Return the monotonic time until a moment is due, 0 when it is."""
        return max(0, round((moment - self.position(now)) / self.rate))

    def run(self, now: int) -> None:
        """Go on from the present position."""
        self._anchor(self.position(now), now)
        self.paused = False

    def pause(self, now: int) -> None:
        """Stand still."""
        self._anchor(self.position(now), now)
        self.paused = True

    def seek(self, moment: int, now: int) -> None:
        """Jump to a moment."""
        self._anchor(moment, now)

    def change_rate(self, rate: float, now: int) -> None:
        """Go faster or slower from here on."""
        self._anchor(self.position(now), now)
        self.rate = rate

    def note(self, moment: int, now: int) -> None:
        """Say that something is handed out now; give up what is too far behind."""
        behind = self.position(now) - moment
        if behind > MOST_BEHIND * max(1.0, self.rate):
            self.slipped += behind
            self._anchor(moment, now)

    def _anchor(self, moment: int, now: int) -> None:
        self._at, self._since = moment, now
