"""Looking at a periodic stream without being woken by it."""

import pytest

from bus.rhythm import Rhythm

PERIOD = 0.004  # s


class Loop:
    """A loop on a clock of its own that reads the newest message of a periodic stream."""

    def __init__(self, offset: float, work: float):
        self.now = 0.0
        self.rhythm = Rhythm(PERIOD, lambda: self.now)
        self._offset, self._work = offset, work
        self._last, self._found = -1, False
        self.lags: list[float] = []
        self.looks = self.skipped = 0

    def run(self, looks: int) -> None:
        """Look so many times; finding a message costs the loop its work."""
        for _ in range(looks):
            self.now += self.rhythm.rest(self._found)
            newest = int((self.now - self._offset) // PERIOD)
            self._found = newest > self._last
            if self._found:
                self.lags.append(self.now - self._offset - newest * PERIOD)
                self.skipped += newest - self._last - 1
                self._last = newest
                self.now += self._work
            self.looks += 1


@pytest.mark.parametrize("offset", [0.0, 0.0011, 0.0039])
@pytest.mark.parametrize("work", [0.0, 0.001])
def test_each_message_is_found_soon_and_few_looks_are_in_vain(offset, work):
    loop = Loop(offset, work)
    loop.run(400)
    loop.lags, before, loop.skipped = [], loop.looks, 0
    loop.run(1000)
    assert loop.skipped == 0
    assert len(loop.lags) > 0.85 * (loop.looks - before)
    assert max(loop.lags) < 0.25 * PERIOD


def test_a_silent_stream_is_looked_at_once_per_period():
    now = [0.0]
    rhythm = Rhythm(PERIOD, lambda: now[0])
    for _ in range(103):
        now[0] += rhythm.rest(False)
    assert now[0] == pytest.approx(100 * PERIOD, rel=0.05)


def test_a_loop_that_was_held_up_does_not_catch_up():
    now = [0.0]
    rhythm = Rhythm(PERIOD, lambda: now[0])
    rhythm.rest(True)
    now[0] = 1.0
    assert rhythm.rest(True) == 0.0
    assert rhythm.rest(True) == pytest.approx(0.97 * PERIOD)
