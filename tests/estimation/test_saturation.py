"""A reading at the end of its range costs its sensor, and the reason names sensor and limit."""

from dataclasses import replace

import numpy as np
import pytest

from estimation.contact.contact_detector import ContactDetector
from estimation.dependencies import ChannelDependencies
from estimation.saturation import Saturation
from estimation.sensor_pipeline import SensorPipeline
from estimation.torque_observer import TorqueObserver
from robot_model import load_robot
from robot_model.messages import RawFrame
from robot_sim import Plant

ROBOT = load_robot("icub")
FOOT = ROBOT.ft_sensors.index("l_foot_ft")
MILLISECOND = 1_000_000  # [ns]


@pytest.fixture(scope="module")
def exact() -> RawFrame:
    return Plant(ROBOT).raw()


def positions(raw: RawFrame) -> RawFrame:
    return replace(raw, dq=None, ddq=None, imu_dgyro=None)


def with_foot(raw: RawFrame, axis: int, value: float) -> RawFrame:
    ft = raw.ft.copy()
    ft[FOOT, axis] = value
    return replace(raw, ft=ft)


def test_icubs_ranges_are_those_of_its_sensors():
    np.testing.assert_array_equal(ROBOT.ft_range, [[1500, 1500, 2000, 35, 35, 25]] * 6)
    np.testing.assert_array_equal(ROBOT.imu_range, [[20.9] * 3 + [50.0] * 3])


@pytest.mark.parametrize("axis", range(6))
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_reading_at_its_limit_is_invalid_and_one_below_it_is_not(exact, axis, sign):
    saturation, limit = Saturation(ROBOT), ROBOT.ft_range[FOOT, axis]
    below = with_foot(exact, axis, sign * 0.999 * limit)
    assert saturation.take_out(below) is below
    at = saturation.take_out(with_foot(exact, axis, sign * limit))
    assert at.ft_valid.tolist() == [i != FOOT for i in range(6)]
    assert not at.ft[FOOT].any() and at.joint_valid.all() and at.imu_valid.all()
    np.testing.assert_array_equal(np.delete(at.ft, FOOT, 0), np.delete(exact.ft, FOOT, 0))


@pytest.mark.parametrize(
    ("field", "axis", "value", "text"),
    [
        ("imu_gyro", 2, -21.0, "head_imu_0: saturated (gyro z reached 20.9 rad/s)"),
        ("imu_acc", 0, 50.0, "head_imu_0: saturated (acceleration x reached 50 m/s^2)"),
    ],
)
def test_an_inertial_sensor_saturates_too_and_the_fault_says_where(exact, field, axis, value, text):
    saturation, pipeline = Saturation(ROBOT), SensorPipeline(ROBOT)
    reading = getattr(exact, field).copy()
    reading[0, axis] = value
    raw = saturation.take_out(replace(exact, **{field: reading}))
    frame = saturation.explain(pipeline.step(raw, 0))
    assert not frame.imu_valid.any() and frame.faults == [text]
    assert not frame.imu_gyro.any() and not frame.imu_acc.any() and frame.ft_valid.all()


def test_the_fault_stays_until_a_whole_window_was_measured_again(exact):
    saturation, pipeline = Saturation(ROBOT), SensorPipeline(ROBOT)
    good, bad = positions(exact), with_foot(positions(exact), 3, 40.0)
    frames = [good] * 60 + [bad] * 2 + [good] * 49
    out = [
        saturation.explain(pipeline.step(saturation.take_out(raw), i * MILLISECOND))
        for i, raw in enumerate(frames)
    ]
    assert out[60].ft_valid.all() and not out[60].faults  # missing once: bridged
    for frame in out[61:110]:
        assert frame.faults == ["l_foot_ft: saturated (mx reached 35 N m)"]
        assert not frame.ft_valid[FOOT] and frame.joint_valid.all()
    assert out[110].ft_valid.all() and not out[110].faults


def test_a_sensor_that_is_missing_is_not_called_saturated(exact):
    saturation = Saturation(ROBOT)
    missing = replace(exact, ft_valid=np.arange(6) != FOOT)
    frame = saturation.explain(SensorPipeline(ROBOT).step(saturation.take_out(missing), 0))
    assert not frame.ft_valid[FOOT] and frame.faults == []


def test_without_ranges_nothing_is_saturated(exact):
    unknown = np.full((6, 6), np.inf), np.full((1, 6), np.inf)
    robot = replace(ROBOT, ft_range=unknown[0], imu_range=unknown[1])
    huge = with_foot(exact, 0, 1e9)
    assert Saturation(robot).take_out(huge) is huge


def test_the_contact_detector_tells_the_limit_for_the_limbs_that_it_concerns(exact):
    saturation, detector = Saturation(ROBOT), ContactDetector(ROBOT, "pole")
    raw = saturation.take_out(with_foot(exact, 2, 2500.0))
    frame = saturation.explain(SensorPipeline(ROBOT).step(raw, 0))
    flags = {flag.limb: flag for flag in detector.step(frame, 0)}
    text = "l_foot_ft is saturated (fz reached 2000 N)"
    assert flags["l_foot"].reason == flags["l_leg"].reason == text
    assert not flags["l_foot"].valid and text not in flags["r_arm"].reason


def test_a_push_beyond_the_range_of_one_sensor_costs_its_sub_trees_and_the_rest_stays_true():
    plant, observer = Plant(ROBOT, base="fixed"), TorqueObserver(ROBOT, "pole")
    plant.push("l_forearm", np.array([0.0, 0.0, 0.05]), np.array([250.0, 0.0, 0.0]))
    for _ in range(5):
        plant.step()
    weak = np.tile([100.0, 100.0, 100.0, 35.0, 35.0, 25.0], (6, 1))  # N, N m
    saturation = Saturation(replace(ROBOT, ft_range=weak))
    frame = SensorPipeline(ROBOT).step(saturation.take_out(plant.raw()), plant.time)
    frame = saturation.explain(frame)
    flags = frame.joint_valid, frame.ft_valid, frame.imu_valid
    validity = ChannelDependencies(observer.graph).validity(*flags, frame.faults)
    lost = {ROBOT.subtrees[i].name for i in np.flatnonzero(~validity.subtree)}
    assert (
        lost == {"root", "l_arm"} and "l_arm_ft is saturated (fx reached 100 N)" in validity.reason
    )
    imu = frame.imu_gyro[0], frame.imu_acc[0], frame.imu_dgyro[0]
    estimate = observer.step(frame.q, frame.dq, frame.ddq, frame.ft, *imu)
    error = np.abs(estimate.torque - plant.truth().link_torque)
    legs = [i for part in ("left_leg", "right_leg") for i in ROBOT.parts[part]]
    assert validity.torque[legs].all() and not validity.torque[ROBOT.parts["left_arm"]].all()
    assert error[validity.torque].max() < 1e-6 < 1.0 < error[~validity.torque].max()
