"""A robot on the pole, watched by torque observers that can be tared there."""

from collections.abc import Hashable, Iterable, Mapping
from dataclasses import replace
from typing import Generic, TypeVar

import numpy as np

from estimation.resting import RestingAverage, StillnessLimits
from estimation.sensor_pipeline import SensorPipeline
from estimation.tare import Tare
from estimation.torque_observer import Estimate, TorqueObserver
from robot_model import Robot
from robot_model.messages import SensorFrame
from robot_sim import Plant

SETTLE, TARE = 2.0, 0.5  # s
STILL = StillnessLimits(joint_velocity=0.02, joint_travel=0.01, angular_velocity=0.05)
LIKELY = 2.0, 0.06  # N and N m of bias that are equally likely
STIFFNESS = 20.0  # factor on the boards' gains: the thesis moves with stiff position control


Name = TypeVar("Name", bound=Hashable)


class PoleRun(Generic[Name]):
    """The plant at rest, the sensor pipeline and the observers, tick by tick.

    Args:
        robot: The robot that is simulated.
        profile: Noise profile of the plant.
        seed: Of the sensors' errors.
        believed: What each observer takes the robot for, by the observer's name.
    """

    def __init__(self, robot: Robot, profile: str, seed: int, believed: Mapping[Name, Robot]):
        self.robot = stiff(robot)
        self.plant = Plant(self.robot, "fixed", profile, seed)
        self._pipeline = SensorPipeline(robot)
        self.observers = {name: TorqueObserver(r, "pole") for name, r in believed.items()}
        self.frame = self._pipeline.step(self.plant.raw(), self.plant.time)
        for _ in range(round(SETTLE * 1e3)):
            self.tick()

    @property
    def instant(self) -> int:
        """The time [ns] that the present frame describes."""
        return self.plant.time - round(self.frame.delay * 1e9)

    @property
    def lag(self) -> int:
        """Ticks from an instant to the frame that describes it."""
        return round(self.frame.delay * 1e3)

    def tick(self) -> SensorFrame:
        """Advance by 1 ms and return the sensor frame."""
        self.plant.step()
        self.frame = self._pipeline.step(self.plant.raw(), self.plant.time)
        return self.frame

    def estimates(self) -> dict[Name, Estimate]:
        """Return what each observer makes of the present frame."""
        f = self.frame
        inertial = f.imu_gyro[0], f.imu_acc[0], f.imu_dgyro[0]
        return {
            name: observer.step(f.q, f.dq, f.ddq, f.ft, *inertial)
            for name, observer in self.observers.items()
        }

    def tare(self, names: Iterable[Name]) -> None:
        """Tell the observers named the offsets that the robot shows at rest."""
        average = RestingAverage(self.robot.joints, STILL)
        for _ in range(round(TARE * 1e3)):
            f = self.tick()
            average.add(f.q, f.dq, f.ft, f.imu_gyro[0], f.imu_acc[0])
        mean = average.mean()
        for observer in map(self.observers.__getitem__, names):
            result = Tare(observer.graph, *LIKELY).solve(mean, "pole", observer.offset)
            observer.offset = result.offset


def stiff(robot: Robot) -> Robot:
    """Return the robot with boards that hold a posture against a push."""
    gains = STIFFNESS * robot.board_kp, np.sqrt(STIFFNESS) * robot.board_kd
    return replace(robot, board_kp=gains[0], board_kd=gains[1])
