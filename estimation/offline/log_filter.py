"""From a log of raw frames to what the estimators take: the sensor pipeline, offline.

The window is that of ``SensorPipeline``, and gives the same numbers; since a log knows what
comes after a sample, they are put at the instant that they describe: no delay is left.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from estimation.differentiation import LEAST, Kernel, differentiate
from estimation.encoder_noise import EncoderNoise
from estimation.offline.sensor_log import FLAGS, SensorBlock, SensorLog

Array = np.ndarray


class LogFilter:
    """Cuts a log into blocks of sensor frames, filtered where motion must be estimated.

    When velocities and all accelerations are given, every sample passes as it is. Otherwise
    all channels go through one window; the first and last ``side`` samples, and those at
    either end of a gap that is too long to be bridged, are in no block. A channel that
    misses more than one sample is invalid as long as the window holds one of them.

    Args:
        log: The log.
        delay: Half width of the window [s]; more where this is less than three samples.
        bridge: Longest step between two stamps that is bridged by straight lines [s].
    """

    def __init__(self, log: SensorLog, delay: float = 0.024, bridge: float = 5e-3):
        self.kernel = None
        self.log = log
        if not log.has_motion:
            period = log.period
            self.kernel = Kernel(period, max(delay, LEAST * period))
            self.log = log.bridged()
            self._encoders = EncoderNoise(self.kernel, log.q.shape[1])
            self._encoders.learn(log.q)
            self._bridge = max(1, round(bridge / period))  # periods

    def blocks(self, length: int) -> Iterator[SensorBlock]:
        """Yield the log in blocks of at most ``length`` samples."""
        if self.kernel is None:
            for rows in _slices(0, len(self.log), length):
                yield _pass(self.log, rows)
            return
        for first, positions in self._segments():
            segment = _Segment(self.log, self.kernel, self._encoders, first, positions)
            yield from segment.blocks(length)

    @property
    def breaks(self) -> Array:
        """Indices of the samples before which the window is emptied: long gaps, odd stamps."""
        if self.kernel is None:
            return np.zeros(0, dtype=int)
        steps = self._steps()
        return np.flatnonzero((steps < 1) | (steps > self._bridge)) + 1

    def _steps(self) -> Array:
        period = round(self.log.period * 1e9)
        return np.rint(np.diff(self.log.stamp) / period).astype(np.int64)

    def _segments(self) -> Iterator[tuple[int, Array]]:
        """Yield the first sample of each stretch without long gaps, and positions in periods."""
        steps, breaks = self._steps(), self.breaks.tolist()
        for first, end in zip([0, *breaks], [*breaks, len(self.log)], strict=True):
            yield first, np.concatenate([[0], np.cumsum(steps[first : end - 1])])


class _Segment:
    """A stretch of a log in which every gap can be bridged."""

    def __init__(
        self, log: SensorLog, kernel: Kernel, encoders: EncoderNoise, first: int, positions: Array
    ):
        self._log, self._kernel, self._first, self._positions = log, kernel, first, positions
        given = log.dq is not None and log.ddq is not None
        self._encoders = None if given else encoders
        motion = ("dq", "ddq") if given else ()
        kinds = ("q", *motion, "motor_torque", "ft", "imu_gyro", "imu_acc", "imu_dgyro")
        self._kinds = [kind for kind in kinds if getattr(log, kind) is not None]

    def blocks(self, length: int) -> Iterator[SensorBlock]:
        positions, side = self._positions, self._kernel.side
        start = int(np.searchsorted(positions, side))
        stop = int(np.searchsorted(positions, positions[-1] - side, side="right"))
        for rows in _slices(start, stop, length):
            yield self._block(rows)

    def _block(self, rows: slice) -> SensorBlock:
        positions, side = self._positions[rows], self._kernel.side
        low = np.searchsorted(self._positions, positions - side, side="right") - 1
        high = np.searchsorted(self._positions, positions + side) + 1
        wide = slice(int(low[0]), int(high[-1]))
        table = self._on_grid(wide, positions[0] - side, positions[-1] + side)
        results = differentiate(table, self._kernel)[:, positions - positions[0] + 2 * side]
        whole = self._valid(low, high)
        return self._assemble(rows, results, whole)

    def _on_grid(self, wide: slice, begin: int, end: int) -> Array:
        """Return the channels (G, columns) at every period, gaps filled with straight lines."""
        at = slice(self._first + wide.start, self._first + wide.stop)
        parts = [getattr(self._log, kind)[at] for kind in self._kinds]
        table = np.concatenate([part.reshape(len(part), -1) for part in parts], axis=1)
        positions, grid = self._positions[wide], np.arange(begin, end + 1)
        if len(positions) == len(grid):
            return table
        left = np.searchsorted(positions, grid, side="right") - 1
        right = np.minimum(left + 1, len(positions) - 1)
        span = np.maximum(positions[right] - positions[left], 1)
        share = ((grid - positions[left]) / span)[:, None]
        return (1.0 - share) * table[left] + share * table[right]

    def _valid(self, low: Array, high: Array) -> dict[str, Array]:
        """Return which channels are valid all over the window of each sample, by flag."""
        first, found = self._first, {}
        begin, end = first + int(low[0]), first + int(high[-1])
        for name in dict.fromkeys(FLAGS.values()):
            missing = ~getattr(self._log, name)[begin:end]
            counts = np.zeros((len(missing) + 1, missing.shape[1]), dtype=np.int64)
            np.cumsum(missing, axis=0, out=counts[1:])
            found[name] = counts[high - low[0]] == counts[low - low[0]]
        return found

    def _assemble(self, rows: slice, results: Array, valid: dict[str, Array]) -> SensorBlock:
        log, columns = self._log, self._split(results)
        value, slope, curvature = ({k: v[row] for k, v in columns.items()} for row in range(3))
        value.setdefault("dq", slope["q"])
        value.setdefault("ddq", curvature["q"])
        value.setdefault("imu_dgyro", slope["imu_gyro"])
        value.setdefault("motor_torque", np.zeros_like(value["q"]))
        for kind, array in value.items():
            array[~valid[FLAGS[kind]]] = 0.0
        of_log = slice(self._first + rows.start, self._first + rows.stop)
        return replace(_block(log, of_log, value, valid), encoders=self._encoders)

    def _split(self, results: Array) -> dict[str, Array]:
        """Return the three results of each kind, (3, B, …)."""
        shapes = {kind: getattr(self._log, kind).shape[1:] for kind in self._kinds}
        ends = np.cumsum([int(np.prod(shape)) for shape in shapes.values()])
        parts = np.split(results, ends[:-1], axis=2)
        return {
            kind: part.reshape(*part.shape[:2], *shape)
            for (kind, shape), part in zip(shapes.items(), parts, strict=True)
        }


def _pass(log: SensorLog, rows: slice) -> SensorBlock:
    kinds = ("q", "dq", "ddq", "motor_torque", "ft", "imu_gyro", "imu_acc", "imu_dgyro")
    value = {kind: getattr(log, kind)[rows] for kind in kinds if getattr(log, kind) is not None}
    value.setdefault("motor_torque", np.zeros_like(value["q"]))
    valid = {name: getattr(log, name)[rows] for name in dict.fromkeys(FLAGS.values())}
    return _block(log, rows, value, valid)


def _block(
    log: SensorLog, rows: slice, value: dict[str, Array], valid: dict[str, Array]
) -> SensorBlock:
    quaternions: dict[str, Any] = {}
    if log.imu_quat_wxyz is not None:
        quaternions["imu_quat_wxyz"] = log.imu_quat_wxyz[rows]
    return SensorBlock(
        rows=rows,
        stamp=log.stamp[rows],
        motor_torque_valid=log.motor_torque is not None,
        **value,
        **valid,
        **quaternions,
    )


def _slices(start: int, stop: int, length: int) -> Iterator[slice]:
    for begin in range(start, stop, length):
        yield slice(begin, min(begin + length, stop))
