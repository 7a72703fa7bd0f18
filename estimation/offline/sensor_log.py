"""What a robot's sensors said over time, sample by sample, as arrays."""

from dataclasses import dataclass, field, fields, replace

import numpy as np

from estimation.encoder_noise import EncoderNoise
from robot_model.messages import SensorFrame

Array = np.ndarray
FLAGS = {"q": "joint_valid", "dq": "joint_valid", "ddq": "joint_valid", "ft": "ft_valid"}
FLAGS |= {"motor_torque": "joint_valid", "imu_quat_wxyz": "imu_valid"}
FLAGS |= dict.fromkeys(("imu_gyro", "imu_acc", "imu_dgyro"), "imu_valid")


@dataclass(frozen=True, eq=False, kw_only=True)
class SensorLog:
    """Raw frames stacked along time: T samples, fields and units as in ``RawFrame``.

    Values are finite, and 0.0 where they are invalid. ``base_quat_wxyz`` (T, 4), world from
    base, is what somebody else knows of the base's attitude.
    """

    stamp: Array  # (T,) int64 ns, strictly rising
    q: Array  # (T, n)
    ft: Array  # (T, k, 6)
    imu_gyro: Array  # (T, m, 3)
    imu_acc: Array  # (T, m, 3)
    joint_valid: Array  # (T, n)
    ft_valid: Array  # (T, k)
    imu_valid: Array  # (T, m)
    dq: Array | None = None
    ddq: Array | None = None
    motor_torque: Array | None = None
    imu_dgyro: Array | None = None
    imu_quat_wxyz: Array | None = None
    base_quat_wxyz: Array | None = None

    def __len__(self) -> int:
        return len(self.stamp)

    @property
    def period(self) -> float:
        """Median time between samples [s]; 1 ms when there is one sample only."""
        return float(np.median(np.diff(self.stamp))) * 1e-9 if len(self) > 1 else 1e-3

    @property
    def has_motion(self) -> bool:
        """Whether velocities and all accelerations are given; else they are estimated."""
        return self.dq is not None and self.ddq is not None and self.imu_dgyro is not None

    def first(self, count: int) -> "SensorLog":
        """Return the first samples."""
        values = {each.name: getattr(self, each.name) for each in fields(self)}
        return replace(self, **{k: v[:count] for k, v in values.items() if v is not None})

    def bridged(self) -> "SensorLog":
        """Return the log with a straight line wherever a channel misses one sample only."""
        changed = {}
        for name in dict.fromkeys(FLAGS.values()):
            valid = getattr(self, name)
            lone = np.zeros_like(valid)
            lone[1:-1] = ~valid[1:-1] & valid[:-2] & valid[2:]
            if lone.any():
                changed |= {kind: self._line(kind, lone) for kind in self._measured(name)}
                changed[name] = valid | lone
        return replace(self, **changed) if changed else self

    def _measured(self, flag: str) -> list[str]:
        known = {field.name for field in fields(self)}
        kinds = (kind for kind, name in FLAGS.items() if name == flag and kind in known)
        return [kind for kind in kinds if getattr(self, kind) is not None]

    def _line(self, kind: str, lone: Array) -> Array:
        values = getattr(self, kind).copy()
        time, channel = np.nonzero(lone)
        whole = self.stamp[time + 1] - self.stamp[time - 1]
        share = (self.stamp[time] - self.stamp[time - 1]) / whole
        share = share.reshape(-1, *[1] * (values.ndim - 2))
        before, after = values[time - 1, channel], values[time + 1, channel]
        values[time, channel] = before + share * (after - before)
        return values


@dataclass(frozen=True, eq=False, kw_only=True)
class SensorBlock:
    """Some samples in a row as the estimators take them: B sensor frames, stacked."""

    rows: slice  # of the log
    stamp: Array  # (B,) ns, of the instant that the values describe
    q: Array
    dq: Array
    ddq: Array
    motor_torque: Array
    ft: Array
    imu_gyro: Array
    imu_acc: Array
    imu_dgyro: Array
    joint_valid: Array
    ft_valid: Array
    imu_valid: Array
    motor_torque_valid: bool
    imu_quat_wxyz: Array | None = None
    encoders: EncoderNoise | None = None  # where accelerations come from positions
    complete: bool = field(init=False)  # every channel is valid in every sample

    def __post_init__(self) -> None:
        flags = (self.joint_valid, self.ft_valid, self.imu_valid)
        object.__setattr__(self, "complete", all(bool(valid.all()) for valid in flags))

    def __len__(self) -> int:
        return len(self.stamp)

    def motion(self, i: int) -> tuple[Array, ...]:
        """Return q, dq, ddq, and gyro, acc, dgyro of the first inertial sensor, of one sample."""
        inertial = self.imu_gyro[i, 0], self.imu_acc[i, 0], self.imu_dgyro[i, 0]
        return self.q[i], self.dq[i], self.ddq[i], *inertial

    def frame(self, i: int) -> SensorFrame:
        """Return one sample as a message."""
        quaternions = self.imu_quat_wxyz
        return SensorFrame(
            q=self.q[i],
            dq=self.dq[i],
            ddq=self.ddq[i],
            motor_torque=self.motor_torque[i],
            ft=self.ft[i],
            imu_gyro=self.imu_gyro[i],
            imu_acc=self.imu_acc[i],
            imu_dgyro=self.imu_dgyro[i],
            imu_quat_wxyz=None if quaternions is None else quaternions[i],
            joint_valid=self.joint_valid[i],
            ft_valid=self.ft_valid[i],
            imu_valid=self.imu_valid[i],
            motor_torque_valid=self.motor_torque_valid,
            ddq_deviation=None if self.encoders is None else self.encoders.deviation(self.dq[i]),
        )
