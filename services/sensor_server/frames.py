"""The sensor frame, its views, and what is said while the driver is silent."""

import time

import numpy as np

from bus import Node
from estimation.saturation import Saturation
from estimation.sensor_pipeline import SensorPipeline, without_nonfinite
from robot_model import Robot, ports
from robot_model.messages import SensorFrame
from services.sensor_server.calibration import Calibrated
from services.sensor_server.config import SensorServerConfig
from services.sensor_server.driver import Driver, FtConvention, Reading
from services.sensor_server.filters import method_of
from services.sensor_server.views import Views

INVALID_PERIOD = 0.02  # s between invalid frames while the driver is silent


class Frames:
    """Turns readings into sensor frames and writes them, and invalid ones during silence."""

    def __init__(self, node: Node, robot: Robot, config: SensorServerConfig, driver: Driver):
        self._robot = robot
        self._convention: FtConvention = driver.ft_convention
        self._check = not driver.checked
        self._saturation = Saturation(robot)
        self._nothing = _nothing(robot)
        self._complained = 0.0  # s
        self.reading: Reading | None = None  # the last valid one
        self.frame = self._nothing
        types = {"model": robot.model_hash, "dimensions": robot.dimensions}
        self._output = node.output(
            ports.name("sensors", robot), SensorFrame, rate=config.rate, **types
        )
        self.views = Views(node, robot, config.rate)
        self.configure(config)

    def configure(self, config: SensorServerConfig) -> None:
        """Take a new filter and calibration; the window starts empty.

        Raises:
            ValueError: The calibration names an unknown sensor.
        """
        self.calibrated = Calibrated(self._robot, self._convention, config.ft)
        filter = config.filter
        self._pipeline = SensorPipeline(
            self._robot,
            period=1.0 / config.rate,
            delay=filter.delay,
            bridge=filter.bridge,
            method=method_of(filter, self._robot),
        )

    def publish(self, reading: Reading) -> bool:
        """Write the sensor frame of a valid reading; True when its stamp jumped back."""
        restarted = self.reading is not None and reading.stamp < self.reading.stamp
        raw = without_nonfinite(reading.frame) if self._check else reading.frame
        raw = self._saturation.take_out(self.calibrated(raw, reading.stamp))
        frame = self._pipeline.step(raw, reading.stamp)
        self.reading, self.frame = reading, self._saturation.explain(frame)
        self._write(self.frame, self._pipeline.reason)
        return restarted

    def complain(self, reason: str) -> None:
        """Write an invalid frame, 50 times per second at most, once there was a valid one."""
        now = time.monotonic()
        if reason and self.reading and now - self._complained >= INVALID_PERIOD:
            self._complained = now
            self.frame = self._nothing
            self._write(self.frame, reason)

    def _write(self, frame: SensorFrame, reason: str) -> None:
        assert self.reading is not None
        _, stamp, clock, acquired, _, _ = self.reading
        for write in (self._output.write, self.views.write):
            write(
                frame,
                stamp=stamp,
                clock=clock,
                acquired=acquired,
                valid=not reason,
                reason=reason,
            )


def _nothing(robot: Robot) -> SensorFrame:
    n, k, m = (robot.dimensions[letter] for letter in "nkm")
    joints, imus = np.zeros(n), np.zeros((m, 3))
    return SensorFrame(
        q=joints,
        dq=joints,
        ddq=joints,
        motor_torque=joints,
        ft=np.zeros((k, 6)),
        imu_gyro=imus,
        imu_acc=imus,
        imu_dgyro=imus,
        joint_valid=np.zeros(n, dtype=bool),
        ft_valid=np.zeros(k, dtype=bool),
        imu_valid=np.zeros(m, dtype=bool),
        motor_torque_valid=False,
    )
