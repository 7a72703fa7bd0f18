"""The session's clock: wall time, or the simulated time that a plant publishes.

A clock runs, is paused, or is absent: a plant publishes at 10 Hz or more of wall
time, also when paused, so a silent clock is an absent one. A reset is a jump back.
"""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Literal

from bus.envelope import SIMULATED, WALL
from bus.signals import stop_flag

if TYPE_CHECKING:
    from bus.input import Input
    from bus.node import Node

SILENCE = 0.5  # s of wall time after which a clock is absent
NAP = 0.01  # s; the end of a sleep is looked for this often by other threads than the node's
State = Literal["running", "paused"]


@dataclass(frozen=True, kw_only=True)
class Clock:
    """Simulated time."""

    TYPE: ClassVar[str] = "Clock/1"
    time: int = field(metadata={"unit": "ns"})
    state: State = field(metadata={"unit": ""})


class SessionClock:
    """What a process knows of the clock; wall time where no clock port is followed.

    Args:
        lockstep: Wall time means nothing here.
        wait: The node's, which handles its requests meanwhile.
        running: False once the node was asked to end.
    """

    def __init__(
        self,
        lockstep: bool = False,
        wait: Callable[[float], bool] | None = None,
        running: Callable[[], bool] = lambda: not stop_flag.set,
    ):
        self.lockstep = lockstep
        self.resets = 0  # jumps back seen so far
        self.resumed_at = 0  # monotonic [ns] of the last end of a pause, 0 without one
        self._time = 0
        self._paused_at = 0
        self._seen_at = 0
        self._input: Input | None = None
        self._wait, self._running = wait, running
        self._thread = threading.get_ident()  # the node's own
        self._reading = threading.RLock()  # what is read may complain, and that be stamped

    def follow(self, clock: "Input") -> None:
        """Take the time from an input of type Clock."""
        self._input = clock

    @property
    def simulated(self) -> bool:
        """Whether a clock port is followed."""
        return self._input is not None

    @property
    def state(self) -> str:
        """``running``, ``paused`` or ``absent``."""
        self.poll()
        if not self.alive:
            return "absent"
        return "paused" if self._paused_at else "running"

    @property
    def time(self) -> int:
        """The session's time [ns]: simulated (0 before the first), or wall time."""
        if self._input is None:
            return time.time_ns()
        self.poll()
        return self._time

    @property
    def alive(self) -> bool:
        """Whether a clock was heard lately."""
        return self._seen_at > 0 and time.monotonic_ns() - self._seen_at < SILENCE * 1e9

    @property
    def paused_at(self) -> int:
        """Monotonic time at which the present pause began [ns], 0 when the clock runs."""
        return self._paused_at if self._paused_at and self.alive else 0

    def now(self) -> tuple[int, int]:
        """Return a stamp of now [ns] and which clock it is of."""
        return self.time, SIMULATED if self.simulated else WALL

    def poll(self) -> None:
        """Take in what the clock port has delivered."""
        if self._input is None:
            return
        with self._reading:
            while (received := self._input.read()) is not None:
                self._note(received.data, received.arrival)

    def wait_until(self, stamp: int, timeout: float) -> bool:
        """Wait for a time of the session [ns], at most ``timeout`` seconds of wall time.

        May be called in any thread; the node's own handles its requests meanwhile. Returns
        whether the time was reached; False also when the clock was reset, or the node
        asked to end.
        """
        resets, deadline = self.resets, time.monotonic() + timeout
        while (now := self.time) < stamp and self.resets == resets:
            remaining = deadline - time.monotonic()
            if remaining <= 0 or not self._running():
                return False
            self._pass(remaining if self.simulated else min(remaining, (stamp - now) * 1e-9))
        return self.resets == resets

    def _pass(self, seconds: float) -> None:
        if self._wait is not None and threading.get_ident() == self._thread:
            self._wait(seconds)
        else:
            time.sleep(min(seconds, NAP))

    def _note(self, clock: Clock, arrival: int) -> None:
        if clock.time < self._time:
            self.resets += 1
        if clock.state == "paused":
            self._paused_at = self._paused_at or arrival
        elif self._paused_at:
            self._paused_at, self.resumed_at = 0, arrival
        self._time, self._seen_at = clock.time, arrival


class ClockServer:
    """Publishes the plant's time; the node's own waits keep it going while paused."""

    def __init__(self, node: "Node", port: str, rate: float = 100.0):
        self._output = node.output(port, Clock, rate=rate)
        self._period = int(1e9 / rate)
        self._stamp = -1
        self._state: State = "running"
        self._due = 0  # monotonic [ns]
        node.beats.append(self.beat)

    def update(self, stamp: int, state: State = "running") -> None:
        """Tell the time [ns]; published at the clock's rate, at once when paused or changed."""
        stepped = state == "paused" and stamp != self._stamp
        if stepped or state != self._state or stamp < self._stamp or self._stamp < 0:
            self._due = 0
        self._stamp, self._state = stamp, state
        self.beat()

    def beat(self) -> None:
        """Publish when it is time to; called by the node while it waits."""
        now = time.monotonic_ns()
        if self._stamp < 0 or now < self._due:
            return
        self._due = now + self._period
        clock = Clock(time=self._stamp, state=self._state)
        self._output.write(clock, stamp=self._stamp, clock=SIMULATED)
