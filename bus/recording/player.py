"""Hands out a recording's messages when they are due; paused, stepped, moved by anybody."""

import time
from collections.abc import Callable, Collection, Iterator
from typing import Any

from bus.node import Node
from bus.recording.read_ahead import Item, ReadAhead, by_sent
from bus.recording.reader import Recording, RecordingError
from bus.recording.timeline import Timeline

RPC = "/player/rpc:i"  # whoever plays answers here
STEP = 0.01  # s
RATES = 0.01, 100.0
UNKNOWN = 0.005  # s after which to ask again when the next message is not read yet


class Player:
    """Where we are in a recording, and what is due; at the end it pauses, or begins again.

    Args:
        tape: The recording.
        ports: Which of its ports are played.
        rate: Speed; None hands out a message whenever it is asked for.
        loop: Begin again at the end.
        begin, end: Part of the recording, in s from its start; all by default.
        paused: Wait for `resume`.

    Attributes:
        ended: The end was reached.
        jumps: How often the position was changed: seeks, and ends of a loop.
        played: Messages that were handed out.
    """

    def __init__(
        self,
        tape: Recording,
        ports: Collection[str],
        rate: float | None = 1.0,
        loop: bool = False,
        begin: float = 0.0,
        end: float | None = None,
        paused: bool = False,
    ):
        self.ended = False
        self.jumps = self.played = 0
        self.loop = loop
        self._more: Callable[[], dict[str, Any]] = dict
        self._tape, self._ports = tape, list(ports)
        self.duration = (tape.end - tape.start) * 1e-9  # s
        self.begin = begin
        self.end = self.duration if end is None else min(end, self.duration)
        if not 0.0 <= begin < max(self.end, 1e-9):
            raise RecordingError(
                f"{tape.path}: expected from < to within its {self.duration:.2f} s,"
                f" got {begin:g} and {self.end:g}"
            )
        self._whole = begin == 0.0 and self.end >= self.duration
        self._asap = rate is None
        self._timeline = Timeline(self._moment(begin), _checked(1.0 if rate is None else rate))
        self._until: int | None = None  # end of a step, of the recording [ns]
        self._ahead = self._read_from(begin)
        if not paused:
            self.resume()

    def next(self) -> Item | None:
        """Return the next message if it is due, else None."""
        if self.paused and self._until is None:
            return None
        item = self._ahead.peek()
        if item is None:
            self._see_whether_it_ends()
            return None
        now, sent = time.monotonic_ns(), item.message.sent
        if self._until is not None:
            if sent >= self._until:
                self._until = None
                return None
        elif self._asap:
            self._timeline.seek(sent, now)
        elif self._timeline.remaining(sent, now):
            return None
        else:
            self._timeline.note(sent, now)
        self._ahead.take()
        self.played += 1
        return item

    @property
    def remaining(self) -> float | None:
        """Seconds until the next message is due; None while paused."""
        if self.paused and self._until is None:
            return None
        item = self._ahead.peek()
        if item is None:
            return UNKNOWN
        if self._asap or self._until is not None:
            return 0.0
        return self._timeline.remaining(item.message.sent, time.monotonic_ns()) * 1e-9

    @property
    def paused(self) -> bool:
        """Whether the position stands still."""
        return self._timeline.paused

    @property
    def position(self) -> float:
        """Seconds from the start of the recording."""
        moment = self._timeline.position(time.monotonic_ns())
        return min(max(0.0, (moment - self._tape.start) * 1e-9), self.duration)

    def serve(self, node: Node, more: Callable[[], dict[str, Any]] = dict) -> None:
        """Let anybody ask: the verbs of ``/player/rpc:i``; ``more`` is added to the status."""
        self._more = more
        verbs = (self.pause, self.resume, self.step, self.seek, self.rate, self.status)
        node.rpc(RPC, {verb.__name__: verb for verb in verbs})

    def pause(self) -> dict[str, Any]:
        """Stand still; the simulated clock is paused."""
        self._timeline.pause(time.monotonic_ns())
        return self.status()

    def resume(self) -> dict[str, Any]:
        """Go on; from the start when the end was reached."""
        if self.ended:
            self._jump(self.begin)
        self._until = None
        self._timeline.run(time.monotonic_ns())
        return self.status()

    def step(self, seconds: float = STEP) -> dict[str, Any]:
        """Play some seconds of the recording at once, then stand still."""
        if not 0.0 < seconds <= 10.0:
            raise ValueError(f"seconds must lie between 0 and 10, got {seconds}")
        now = time.monotonic_ns()
        self._timeline.pause(now)
        if not self.ended:
            self._until = self._timeline.position(now) + round(seconds * 1e9)
            self._timeline.seek(self._until, now)
        return self.status()

    def seek(self, time: float) -> dict[str, Any]:
        """Go to a time [s] from the start of the recording; while paused, show what is there."""
        self._jump(min(max(time, self.begin), self.end))
        if self.paused:
            self.step()
        return self.status()

    def rate(self, value: float) -> dict[str, Any]:
        """Set the speed: 1 is that of the recording."""
        self._timeline.change_rate(_checked(value), time.monotonic_ns())
        return self.status()

    def status(self) -> dict[str, Any]:
        """File, position and duration [s], speed, and whether it plays."""
        return {
            "file": str(self._tape.path),
            "position": round(self.position, 4),
            "duration": round(self.duration, 4),
            "begin": self.begin,
            "end": round(self.end, 4),
            "rate": None if self._asap else self._timeline.rate,
            "loop": self.loop,
            "paused": self.paused,
            "ended": self.ended,
            "played": self.played,
            "slipped_s": self._timeline.slipped * 1e-9,
            **self._more(),
        }

    def close(self) -> None:
        """Read no further."""
        self._ahead.close()

    def _see_whether_it_ends(self) -> None:
        if not self._ahead.ended:
            return
        self._until = None
        if self.loop and not self.paused:
            self._jump(self.begin)
            return
        now = time.monotonic_ns()
        self._timeline.pause(now)
        self._timeline.seek(self._moment(self.end), now)
        self.ended = True

    def _jump(self, seconds: float) -> None:
        self.jumps += 1
        self.ended, self._until = False, None
        self._timeline.seek(self._moment(seconds), time.monotonic_ns())
        self._ahead.close()
        self._ahead = self._read_from(seconds)

    def _moment(self, seconds: float) -> int:
        return self._tape.start + round(seconds * 1e9)

    def _read_from(self, seconds: float) -> ReadAhead:
        first = self._moment(seconds) if seconds > 0.0 else None
        last = None if self._whole else self._moment(self.end)
        return ReadAhead(self._items(first, last))

    def _items(self, first: int | None, last: int | None) -> Iterator[Item]:
        """What was sent within a part; what arrived earlier was sent earlier."""
        messages = self._tape.messages(self._ports, first, None)
        for item in by_sent(messages, len(self._ports) > 1):
            if last is not None and item.message.sent >= last:
                return
            if first is None or item.message.sent >= first:
                yield item


def _checked(rate: float) -> float:
    low, high = RATES
    if not low <= rate <= high:
        raise ValueError(f"rate must lie between {low} and {high}, got {rate}")
    return float(rate)
