"""Where up is in the base's axes, over a log: given, or from the base estimator."""

import numpy as np

from estimation.base_estimator import BaseEstimator, BaseSample
from robot_model.messages import SensorFrame

Array = np.ndarray
LONGEST_STEP = 0.05  # s; over a longer gap nothing is integrated


def upward(quat_wxyz: Array) -> Array:
    """Return upwards in base axes, (…, 3), of quaternions world from base, (…, 4)."""
    w, x, y, z = (quat_wxyz / np.linalg.norm(quat_wxyz, axis=-1, keepdims=True)).T
    return np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=-1)


class GivenUpward:
    """Up by quaternions (T, 4) world from base, one per sample of the log."""

    def __init__(self, quat_wxyz: Array):
        self._up = upward(quat_wxyz)

    def __call__(self, frame: SensorFrame, row: int) -> Array:
        return self._up[row]


class EstimatedUpward:
    """Up by the base estimator, at every ``every``-th sample; None while it knows nothing.

    Args:
        estimator: Of the robot and its support.
        stamp: (T,) ns of the log.
        every: Samples between estimates.
    """

    def __init__(self, estimator: BaseEstimator, stamp: Array, every: int):
        self._estimator, self._stamp, self._every = estimator, stamp, every
        self._last: int | None = None  # row of the last estimate
        self._up: Array | None = None

    def __call__(self, frame: SensorFrame, row: int) -> Array | None:
        if self._last is not None and row < self._last:
            self._estimator.reset()
            self._last = None
        if self._last is None or row - self._last >= self._every:
            begin = row if self._last is None else self._last
            period = 1e-9 * float(self._stamp[row] - self._stamp[begin])
            self._up = self._estimate(frame, period if period <= LONGEST_STEP else 0.0)
            self._last = row
        return self._up

    def _estimate(self, frame: SensorFrame, period: float) -> Array | None:
        estimate = self._estimator.step(BaseSample.of(frame), period)
        return None if estimate.reason else estimate.rotation[2]
