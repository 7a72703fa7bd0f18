"""What acted on a robot between two evaluations of its residuals."""

import numpy as np

Array = np.ndarray


class Impulse:
    """Means of motor torques and readings between two evaluations, by the trapezoidal rule.

    Samples are kept, not copied.
    """

    def __init__(self) -> None:
        # samples since the last evaluation, its own included, and the times between them
        self._torques: list[Array] = []
        self._readings: list[Array] = []
        self._periods: list[float] = []

    def add(self, torque: Array, ft: Array, period: float) -> None:
        """Add a sample ``period`` seconds after the last one; 0 starts again."""
        if period <= 0.0:
            self._torques, self._readings, self._periods = [], [], []
        else:
            self._periods.append(period)
        self._torques.append(torque)
        self._readings.append(ft)

    def take_mean(self) -> tuple[Array, Array, float]:
        """Return mean torque and readings since the last call, and the time passed [s]."""
        torques, readings, periods = self._torques, self._readings, self._periods
        self._torques, self._readings, self._periods = torques[-1:], readings[-1:], []
        time = sum(periods)
        if len(periods) == 1:
            return 0.5 * (torques[0] + torques[1]), 0.5 * (readings[0] + readings[1]), time
        half = 0.5 / time if time else 0.0
        before, after = [0.0, *periods], [*periods, 0.0]
        weights = [half * (x + y) for x, y in zip(before, after, strict=True)]
        flat = np.array(readings).reshape(len(readings), -1)
        return np.dot(weights, torques), np.dot(weights, flat).reshape(readings[0].shape), time
