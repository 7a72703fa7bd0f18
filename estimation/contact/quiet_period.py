"""What the contact detector learns while the robot rests untouched."""

from dataclasses import dataclass

import numpy as np

from estimation.resting import MovingError, RestingAverage, StillnessLimits
from robot_model.messages import SensorFrame

Array = np.ndarray
STILL = StillnessLimits(joint_velocity=0.05, joint_travel=0.02, angular_velocity=0.05)


@dataclass(frozen=True, eq=False)
class Quiet:
    """Statistics of a quiet period; its mean is the tare.

    Whoever is touched all the time is tared too: only the supports may touch.
    """

    rows: Array  # (nv,) mean of the touches' rows: biases of sensors and model
    ft: Array  # (k, 6) mean of the readings
    spread: Array  # (samples, nv) rows about their mean
    frames: tuple[SensorFrame, ...]
    predictions: Array  # (samples, nv) by the model
    touches: Array  # (samples, nv) rows after the tare that was in force
    wrenches: Array  # (samples, s, 6) of the sub-trees, before the tare
    residual_mean: Array  # of the residuals
    residual_std: Array
    travel: Array  # (n,) between the extremes of each joint, rad
    samples: int


class QuietPeriod:
    """Collects samples of a resting robot."""

    def __init__(self, joints: tuple[str, ...], limits: StillnessLimits = STILL):
        self._rest = RestingAverage(joints, limits)
        self._rows: list[Array] = []
        self._touches: list[Array] = []
        self._predicted: list[Array] = []
        self._ft: list[Array] = []
        self._wrenches: list[Array] = []
        self._residuals: list[Array] = []
        self._frames: list[SensorFrame] = []

    def add(
        self,
        frame: SensorFrame,
        rows: Array,
        predicted: Array,
        wrenches: Array,
        residuals: Array,
        touch: Array | None = None,
    ) -> None:
        """Add one complete sample; rows and wrenches before any tare, ``touch`` after it."""
        self._rest.add(frame.q, frame.dq, frame.ft, frame.imu_gyro[0], frame.imu_acc[0])
        self._frames.append(frame)
        self._rows.append(rows.copy())
        self._touches.append(rows.copy() if touch is None else touch.copy())
        self._predicted.append(predicted.copy())
        self._ft.append(frame.ft.copy())
        self._wrenches.append(wrenches)
        self._residuals.append(residuals)

    def finish(self, still: bool = True) -> Quiet:
        """Return the statistics.

        Raises:
            MovingError: Too few samples came, or the robot moved although it had to be still.
        """
        if len(self._rows) < 10:
            raise MovingError(
                f"only {len(self._rows)} complete samples came; a tare needs every sensor"
            )
        if still:
            self._rest.mean()
        residuals, rows = np.array(self._residuals), np.array(self._rows)
        return Quiet(
            rows=rows.mean(axis=0),
            spread=rows - rows.mean(axis=0),
            frames=tuple(self._frames),
            predictions=np.array(self._predicted),
            touches=np.array(self._touches),
            ft=np.mean(self._ft, axis=0),
            wrenches=np.array(self._wrenches),
            residual_mean=residuals.mean(axis=0),
            residual_std=residuals.std(axis=0),
            travel=self._rest.travel,
            samples=len(self._rows),
        )
