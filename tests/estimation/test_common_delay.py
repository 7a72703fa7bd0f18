"""Filtering one channel and not another makes wrenches of nothing on a robot that moves."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
import pytest

from estimation.adaptive_window import AdaptiveWindow
from estimation.differentiation import Kernel, Method
from estimation.kalman_window import KalmanWindow
from estimation.sensor_pipeline import SensorPipeline, column_values
from estimation.torque_observer import TorqueObserver
from robot_model import load_robot
from robot_model.messages import RawFrame
from robot_sim import Plant
from robot_sim.motions import Motion, Sinusoid

ROBOT = load_robot("icub")
MOVED = ("torso_pitch", "torso_yaw", "l_shoulder_pitch", "l_elbow", "r_shoulder_roll")
FADED_IN, TICKS, EVERY = 2000, 3000, 10
STEP = 2.0 * np.pi / 2**16  # [rad] of the plant's encoders
# the sensors but the encoders are exact: their bounds only need to be small
BOUND = column_values(ROBOT, STEP, 0.1, 0.1, 0.005, 0.001, 0.01)
METHODS: dict[str, Callable[[float, float], Method]] = {
    "triweight": Kernel,
    "adaptive": partial(AdaptiveWindow, bound=BOUND),
    "kalman": partial(KalmanWindow, noise=STEP / 12**0.5, jerk=10.0, memory=0.048),
}


class Moving(NamedTuple):
    """What exact sensors and encoders of 16 bits deliver on the pole; nobody touches the robot."""

    frames: list[RawFrame]
    stamps: list[int]


@pytest.fixture(scope="module")
def moving(tmp_path_factory) -> Moving:
    profile = tmp_path_factory.mktemp("profile") / "encoders.yaml"
    profile.write_text("encoder_bits: 16\n")
    plant = Plant(ROBOT, base="fixed", profile=profile)
    swing = Sinusoid(amplitude=0.3, frequency=1.0)
    plant.motion(Motion("swing", dict.fromkeys(MOVED, swing)))
    frames, stamps = [], []
    for _ in range(TICKS):
        plant.step()
        if plant.time >= FADED_IN * 1_000_000:
            frames.append(plant.raw())
            stamps.append(plant.time)
    return Moving(frames, stamps)


def false_wrenches(moving: Moving, method: Callable[[float, float], Method], common: bool):
    """RMS of the wrenches of the limbs, which nobody touches, (subtrees, 6)."""
    observer, pipeline = TorqueObserver(ROBOT, "pole"), SensorPipeline(ROBOT, method=method)
    found = []
    for index, (raw, stamp) in enumerate(zip(*moving, strict=True)):
        frame = pipeline.step(raw, stamp)
        if frame.joint_valid.all() and index % EVERY == 0:
            now = raw if not common else frame
            imu = now.imu_gyro[0], now.imu_acc[0], frame.imu_dgyro[0]
            found.append(observer.step(frame.q, frame.dq, frame.ddq, now.ft, *imu).wrench[1:])
    return np.sqrt(np.mean(np.square(found), axis=0))


@pytest.mark.parametrize("name", METHODS)
def test_one_delay_for_all_channels_makes_smaller_false_wrenches_than_filtered_joints(
    moving, name: str
):
    common = false_wrenches(moving, METHODS[name], common=True)
    joints_only = false_wrenches(moving, METHODS[name], common=False)
    assert common[:, :3].max() < 1.0 < 5.0 < joints_only[:, :3].max()  # N
    for part in (slice(0, 3), slice(3, 6)):  # forces, moments
        ratio = joints_only[:, part].max(axis=1) / common[:, part].max(axis=1)
        assert (ratio > 1.2).all()  # feet hardly move: what is left is quantisation
        assert (ratio[:4] > 4.0).all()  # arms and legs
