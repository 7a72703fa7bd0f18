"""From a driver's raw frames to sensor frames: one filter, one delay, honest flags.

When the driver measures velocities, accelerations and angular accelerations
itself, everything passes through with delay 0. Otherwise positions and
gyroscopes are differentiated and every other channel goes through the same
method: all values describe one instant. Velocities that come without
accelerations are not used: boards filter them with delays that nobody states.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import fields, replace
from math import isfinite
from typing import Any

import numpy as np

from estimation.differentiation import Differentiator, Kernel, Method, Weights
from estimation.encoder_noise import EncoderNoise
from robot_model import Robot
from robot_model.messages import RawFrame, SensorFrame

Array = np.ndarray
JUDGE = 4  # frames after which the noise of the accelerations is told anew
FLAG_OF_FIELD = {"q": "joint_valid", "dq": "joint_valid", "ddq": "joint_valid"}
FLAG_OF_FIELD |= {"motor_torque": "joint_valid", "ft": "ft_valid", "imu_quat_wxyz": "imu_valid"}
FLAG_OF_FIELD |= dict.fromkeys(("imu_gyro", "imu_acc", "imu_dgyro"), "imu_valid")


def column_values(
    robot: Robot,
    position: float,
    torque: float,
    force: float,
    moment: float,
    gyro: float,
    acceleration: float,
) -> Array:
    """Return one number per value that a ``SensorPipeline`` filters, for each kind of channel."""
    n, k, m = (robot.dimensions[letter] for letter in "nkm")
    ft = np.tile([force] * 3 + [moment] * 3, k)
    kinds = [(position, n), (torque, n), (gyro, 3 * m), (acceleration, 3 * m)]
    q, motor, rate, acc = (np.full(count, value) for value, count in kinds)
    return np.concatenate([q, motor, ft, rate, acc])


class SensorPipeline:
    """Raw frames in, sensor frames out; pure, and the same live, in tests and on logs.

    A channel (a joint, a force/torque sensor, an inertial sensor) that a filtered
    frame lacks is extrapolated once; lacking in two frames, it is invalid until a
    whole window of it has been measured again. Lost frames are bridged by a
    straight line up to ``bridge``; a longer gap, or a stamp that jumps back,
    empties the window.

    Args:
        robot: Supplies the numbers of joints and sensors.
        period: Nominal time between frames [s].
        delay: Age of the filtered values [s].
        bridge: Longest step between two stamps that is bridged [s].
        method: Makes the method of differentiation from period and delay.
    """

    def __init__(
        self,
        robot: Robot,
        period: float = 1e-3,
        delay: float = 0.024,
        bridge: float = 5e-3,
        method: Callable[[float, float], Method] = Kernel,
    ):
        self.method = method(period, delay)
        self._period = round(period * 1e9)  # [ns]
        self._bridge = max(1, round(bridge / period))  # [periods]
        self._window = _Window(self.method, *(robot.dimensions[letter] for letter in "nkm"))
        self._filtering = False
        self._stamp: int | None = None

    @property
    def reason(self) -> str:
        """Why nothing of the last frame is valid yet; empty when the window is full."""
        length = self.method.length
        if not self._filtering or self._window.count >= length:
            return ""
        return f"the filter's window holds {self._window.count} of {length} frames"

    def reset(self) -> None:
        """Forget every frame."""
        self._window.reset()
        self._stamp = None

    def step(self, raw: RawFrame, stamp: int) -> SensorFrame:
        """Take one raw frame and return the sensor frame of the same stamp [ns].

        Force/torque readings are in the convention of Wrenchbus. All values are
        finite, and 0.0 where invalid, as on the bus; see ``without_nonfinite``.
        """
        self._filtering = raw.dq is None or raw.ddq is None or raw.imu_dgyro is None
        if not self._filtering:
            if self._stamp is not None:
                self.reset()
            return _pass(raw)
        steps = 1 if self._stamp is None else round((stamp - self._stamp) / self._period)
        if not 1 <= steps <= self._bridge:
            self.reset()
            steps = 1
        self._stamp = stamp
        return self._window.step(raw, steps)


def without_nonfinite(raw: RawFrame) -> RawFrame:
    """Clear the flag of every channel that is not finite, and zero the invalid ones."""
    flags = np.concatenate((raw.joint_valid, raw.ft_valid, raw.imu_valid))
    values = [value for name in FLAG_OF_FIELD if (value := getattr(raw, name)) is not None]
    block = np.concatenate(values, axis=None)
    with np.errstate(over="ignore", invalid="ignore"):
        # a third of the time of isfinite().all(); huge values only take the long way
        square = block @ block
    return raw if flags.all() and isfinite(square) else _masked(raw)


def _masked(raw: RawFrame) -> RawFrame:
    changed: dict[str, Any] = {f.name: getattr(raw, f.name) for f in fields(raw)}
    present = {name: flag for name, flag in FLAG_OF_FIELD.items() if changed[name] is not None}
    for name, flag in present.items():
        value = changed[name]
        changed[flag] = changed[flag] & np.isfinite(value).reshape(len(value), -1).all(axis=1)
    for name, flag in present.items():
        value = changed[name]
        valid = changed[flag].reshape((-1,) + (1,) * (value.ndim - 1))
        changed[name] = np.where(valid, value, 0.0)
    return replace(raw, **changed)


def _pass(raw: RawFrame) -> SensorFrame:
    torque = raw.motor_torque
    assert raw.dq is not None and raw.ddq is not None and raw.imu_dgyro is not None
    return SensorFrame(
        q=raw.q,
        dq=raw.dq,
        ddq=raw.ddq,
        motor_torque=np.zeros_like(raw.q) if torque is None else torque,
        ft=raw.ft,
        imu_gyro=raw.imu_gyro,
        imu_acc=raw.imu_acc,
        imu_dgyro=raw.imu_dgyro,
        imu_quat_wxyz=raw.imu_quat_wxyz,
        joint_valid=raw.joint_valid,
        ft_valid=raw.ft_valid,
        imu_valid=raw.imu_valid,
        motor_torque_valid=torque is not None,
    )


class _Window:
    """The filter's window over all channels of a robot, and what in it was measured."""

    def __init__(self, method: Method, n: int, k: int, m: int):
        self._delay, self._side, self._length = method.delay, method.side, method.length
        self._n, self._k, self._m = n, k, m
        ends = [0, *np.cumsum([n, n, 6 * k, 3 * m, 3 * m]).tolist()]
        self._columns = [slice(start, end) for start, end in zip(ends, ends[1:], strict=False)]
        joints, sensors, imus = np.split(np.arange(n + k + m), [n, n + k])
        self._channel = np.concatenate(  # of each column
            [joints, joints, sensors.repeat(6), imus.repeat(3), imus.repeat(3)]
        )
        self._row = np.zeros(len(self._channel))
        self._filter = Differentiator(method, len(self._channel))
        self._encoders = EncoderNoise(method, n) if isinstance(method, Weights) else None
        self._deviation: Array | None = None
        self._judged = 0  # frames ago
        self._good = np.zeros(n + k + m, dtype=int)  # frames in a row, one missing bridged
        self._absent = np.zeros(n + k + m, dtype=int)  # frames in a row
        self._quaternions: deque[Array] = deque(maxlen=self._side + 1)
        self._torques = 0  # frames in a row with motor torques
        self._no_torque = np.zeros(n)
        # comparing bytes takes a tenth of the time of ndarray.all()
        self._whole = tuple(np.ones(size, dtype=bool) for size in (n, k, m))
        self._all = tuple(flags.tobytes() for flags in self._whole)
        self._complete = False  # every channel has been measured for a whole window

    @property
    def count(self) -> int:
        return self._filter.count

    def reset(self) -> None:
        self._filter.reset()
        self._good[:] = self._absent[:] = 0
        self._torques = 0
        self._complete = False
        self._quaternions.clear()

    def step(self, raw: RawFrame, steps: int) -> SensorFrame:
        """Append a frame ``steps`` periods after the last one."""
        self._gather(raw)
        if self._encoders is not None:
            self._encoders.see(raw.q)
        self._mark(raw, steps)
        if steps > 1:
            previous = self._filter.newest.copy()
            for step in range(1, steps):
                self._filter.put(previous + (self._row - previous) * (step / steps))
        self._filter.put(self._row)
        self._keep_quaternion(raw, steps)
        return self._frame()

    def _gather(self, raw: RawFrame) -> None:
        torque = self._no_torque if raw.motor_torque is None else raw.motor_torque
        blocks = (raw.q, torque, raw.ft.ravel(), raw.imu_gyro.ravel(), raw.imu_acc.ravel())
        np.concatenate(blocks, out=self._row)

    def _mark(self, raw: RawFrame, steps: int) -> None:
        """Count what was measured; a channel that is missing for once gets a guess."""
        self._torques = 0 if raw.motor_torque is None else self._torques + steps
        flags = (raw.joint_valid, raw.ft_valid, raw.imu_valid)
        measured = tuple(flag.tobytes() for flag in flags) == self._all
        if measured and self._complete:
            return
        self._good += steps
        if measured:
            self._absent[:] = 0
        else:
            self._guess(np.concatenate(flags), steps)
        self._complete = bool(self._good.min(initial=self._length) >= self._length)

    def _guess(self, measured: Array, steps: int) -> None:
        self._absent = np.where(measured, 0, self._absent + 1)
        # a straight line needs two samples before the missing one
        bridged = (self._absent == 1) & (self._good >= steps + 2)
        self._good[~measured & ~bridged] = 0
        columns = bridged[self._channel]
        self._row[columns] = self._filter.extrapolated[columns]

    def _keep_quaternion(self, raw: RawFrame, steps: int) -> None:
        if raw.imu_quat_wxyz is None:
            self._quaternions.clear()
            return
        for _ in range(steps):
            self._quaternions.append(raw.imu_quat_wxyz)

    def _frame(self) -> SensorFrame:
        values, flags = self._filter.result(), self._whole
        if not self._complete:
            valid = self._good >= self._length
            values[:, ~valid[self._channel]] = 0.0
            flags = np.split(valid, [self._n, self._n + self._k])
        joint_valid, ft_valid, imu_valid = flags
        value, slope, curvature = values
        q, torque, ft, gyro, acc = self._columns
        k, m = self._k, self._m
        rotated = len(self._quaternions) > self._side
        self._judge(slope[q])
        return SensorFrame(
            q=value[q],
            dq=slope[q],
            ddq=curvature[q],
            motor_torque=value[torque],
            ft=value[ft].reshape(k, 6),
            imu_gyro=value[gyro].reshape(m, 3),
            imu_acc=value[acc].reshape(m, 3),
            imu_dgyro=slope[gyro].reshape(m, 3),
            imu_quat_wxyz=self._quaternions[0] if rotated else None,
            joint_valid=joint_valid,
            ft_valid=ft_valid,
            imu_valid=imu_valid,
            motor_torque_valid=self._torques >= self._length,
            delay=self._delay,
            ddq_deviation=self._deviation,
        )

    def _judge(self, dq: Array) -> None:
        """Tell how wrong the accelerations are, from time to time."""
        self._judged -= 1
        if self._encoders is not None and self._judged < 0:
            self._judged = JUDGE
            self._deviation = self._encoders.deviation(dq)
