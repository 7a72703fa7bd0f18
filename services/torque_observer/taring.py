"""The tare on demand: collects resting samples, then answers the caller."""

import time
from collections.abc import Callable
from typing import Any

from bus import Pending
from estimation.resting import RestingAverage, RestingMean, TareError
from robot_model.messages import SensorFrame

PATIENCE = 5.0  # s of wall time without a frame; a simulation may be slow

Solve = Callable[[RestingMean], dict[str, Any]]


class Taring:
    """One tare at a time."""

    def __init__(self) -> None:
        self._pending: Pending | None = None

    def begin(
        self, seconds: float, average: RestingAverage, solve: Solve, samples: int = 0
    ) -> Pending:
        """Collect for a time of the frames, or a number of them; answer with what ``solve`` finds.

        Args:
            seconds: How long; the usual length of ``samples`` when these are given.
            average: What the frames are added to.
            solve: Called with their mean.
            samples: How many complete frames; 0: as many as come in ``seconds``.

        Raises:
            ValueError: A meaningless duration.
            RuntimeError: A tare is running already.
        """
        if not 0.01 <= seconds <= 60.0:
            raise ValueError(f"a tare takes 0.01 to 60 s, got {seconds} s")
        if self._pending is not None:
            raise RuntimeError("a tare is running already")
        self._average, self._solve = average, solve
        self._nanoseconds, self._end = int(seconds * 1e9), 0
        self._samples = samples
        self._deadline = time.monotonic() + PATIENCE
        self._pending = Pending()
        return self._pending

    @property
    def active(self) -> bool:
        return self._pending is not None

    def add(self, frame: SensorFrame, stamp: int) -> None:
        """Take one complete frame."""
        self._deadline = time.monotonic() + PATIENCE
        if self._end == 0:
            self._end = stamp + self._nanoseconds
        self._average.add(frame.q, frame.dq, frame.ft, frame.imu_gyro[0], frame.imu_acc[0])
        if self._average.samples >= self._samples if self._samples else stamp >= self._end:
            self._finish()

    def abandon(self, reason: str) -> None:
        """End an unfinished tare with an error."""
        if self._pending is not None:
            pending, self._pending = self._pending, None
            pending.fail(reason)

    def watch(self) -> None:
        """Give up when complete frames stay away."""
        if self._pending is not None and time.monotonic() > self._deadline:
            self.abandon("too few complete sensor frames came; see the status of sensor_server")

    def _finish(self) -> None:
        assert self._pending is not None
        pending, self._pending = self._pending, None
        try:
            answer = self._solve(self._average.mean())
        except TareError as error:
            pending.fail(f"not tared: {error}")
        else:
            pending.reply(answer)
