"""Views of the sensor frame, part by part, for whoever wants only one."""

from collections.abc import Callable

import numpy as np

from bus import Node, Output
from robot_model import Robot, ports
from robot_model.messages import Inertial, PartForceTorque, PartState, SensorFrame

View = Callable[[SensorFrame], object]
LOOK = 8  # frames between looks at who listens


class Views:
    """Part states, force/torque sensors by part, inertial sensors; free while nobody listens."""

    def __init__(self, node: Node, robot: Robot, rate: float):
        self._views: list[tuple[Output, View]] = []
        self._heard: list[tuple[Output, View]] = []
        self._written = 0
        for part, indices in robot.parts.items():
            name = ports.name("state", robot, part)
            output = node.output(name, PartState, rate=rate, model=robot.model_hash)
            self._views.append((output, _state_view(robot, indices)))
        for part, indices in robot.part_sensors.items():
            if len(indices):
                output = node.output(ports.name("ft", robot, part), PartForceTorque, rate=rate)
                self._views.append((output, _ft_view(robot, indices)))
        if robot.imus:
            output = node.output(
                ports.name("inertial", robot), Inertial, rate=rate, dimensions=robot.dimensions
            )
            self._views.append((output, _inertial_view(robot)))

    @property
    def outputs(self) -> list[Output]:
        """The ports."""
        return [output for output, _ in self._views]

    def write(
        self, frame: SensorFrame, stamp: int, clock: int, acquired: int, valid: bool, reason: str
    ) -> None:
        """Write every view that somebody listens to, with the frame's times [ns]."""
        self._written += 1
        if self._written % LOOK == 0:
            self._heard = [(output, view) for output, view in self._views if output.heard]
        for output, view in self._heard:
            if output.wanted(stamp, valid):
                output.write(
                    view(frame),
                    stamp=stamp,
                    clock=clock,
                    acquired=acquired,
                    valid=valid,
                    reason=reason,
                )


def _state_view(robot: Robot, indices: np.ndarray) -> View:
    joints = [robot.joints[i] for i in indices]

    def view(frame: SensorFrame) -> PartState:
        return PartState(
            joints=joints,
            q=frame.q[indices],
            dq=frame.dq[indices],
            ddq=frame.ddq[indices],
            motor_torque=frame.motor_torque[indices],
            joint_valid=frame.joint_valid[indices],
            motor_torque_valid=frame.motor_torque_valid,
            delay=frame.delay,
        )

    return view


def _ft_view(robot: Robot, indices: np.ndarray) -> View:
    sensors = [robot.ft_sensors[i] for i in indices]

    def view(frame: SensorFrame) -> PartForceTorque:
        return PartForceTorque(
            sensors=sensors,
            ft=frame.ft[indices],
            ft_valid=frame.ft_valid[indices],
            delay=frame.delay,
        )

    return view


def _inertial_view(robot: Robot) -> View:
    sensors = list(robot.imus)

    def view(frame: SensorFrame) -> Inertial:
        return Inertial(
            sensors=sensors,
            imu_gyro=frame.imu_gyro,
            imu_acc=frame.imu_acc,
            imu_dgyro=frame.imu_dgyro,
            imu_quat_wxyz=frame.imu_quat_wxyz,
            imu_valid=frame.imu_valid,
            delay=frame.delay,
        )

    return view
