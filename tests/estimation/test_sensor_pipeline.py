from collections.abc import Callable
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from estimation.adaptive_window import AdaptiveWindow
from estimation.differentiation import Kernel, Method
from estimation.kalman_window import KalmanWindow
from estimation.sensor_pipeline import SensorPipeline, column_values, without_nonfinite
from robot_model.messages import RawFrame

ROBOT: Any = SimpleNamespace(dimensions={"n": 3, "k": 2, "m": 1})
MILLISECOND = 1_000_000  # [ns]


def raw_frame(index: int, direct: bool = False) -> RawFrame:
    """Position, torque and force that are ramps in time; gyro likewise."""
    time = index * 1e-3  # [s]
    frame = RawFrame(
        q=time * np.array([1.0, 2.0, 3.0]),
        motor_torque=np.full(3, time),
        ft=np.full((2, 6), 10.0 * time),
        imu_gyro=np.full((1, 3), 5.0 * time),
        imu_acc=np.full((1, 3), 9.81),
        imu_quat_wxyz=np.array([[1.0, 0.0, 0.0, index]]),
        joint_valid=np.ones(3, dtype=bool),
        ft_valid=np.ones(2, dtype=bool),
        imu_valid=np.ones(1, dtype=bool),
    )
    if not direct:
        return frame
    return replace(frame, dq=np.full(3, 7.0), ddq=np.full(3, 8.0), imu_dgyro=np.full((1, 3), 9.0))


def run(pipeline: SensorPipeline, start: int, stop: int, change=lambda index, raw: raw):
    frame = None
    for index in range(start, stop):
        frame = pipeline.step(change(index, raw_frame(index)), index * MILLISECOND)
    assert frame is not None
    return frame


BOUND = column_values(
    ROBOT, position=1e-4, torque=0.4, force=1.0, moment=0.04, gyro=0.02, acceleration=0.08
)
METHODS: dict[str, Callable[[float, float], Method]] = {
    "triweight": Kernel,
    "adaptive": partial(AdaptiveWindow, bound=BOUND),
    "line": partial(AdaptiveWindow, bound=BOUND, order=1),
    "kalman": partial(KalmanWindow, noise=2.8e-5, jerk=10.0, memory=0.048),
}


@pytest.fixture(params=METHODS)
def pipeline(request) -> SensorPipeline:
    return SensorPipeline(ROBOT, method=METHODS[request.param])


def test_all_channels_describe_the_same_instant(pipeline):
    frame = run(pipeline, 0, 80)
    then = 79e-3 - frame.delay
    assert frame.delay == 0.024
    np.testing.assert_allclose(frame.q, then * np.array([1.0, 2.0, 3.0]), atol=1e-12)
    np.testing.assert_allclose(frame.dq, [1.0, 2.0, 3.0], atol=1e-10)
    np.testing.assert_allclose(frame.ddq, 0.0, atol=1e-8)
    np.testing.assert_allclose(frame.motor_torque, then, atol=1e-12)
    np.testing.assert_allclose(frame.ft, 10.0 * then, atol=1e-12)
    np.testing.assert_allclose(frame.imu_gyro, 5.0 * then, atol=1e-12)
    np.testing.assert_allclose(frame.imu_dgyro, 5.0, atol=1e-10)
    assert frame.imu_quat_wxyz is not None and frame.imu_quat_wxyz[0, 3] == 79 - 24


def test_the_angular_acceleration_of_an_inertial_sensor_is_estimated_at_the_same_instant(pipeline):
    def turning(index: int, raw: RawFrame) -> RawFrame:
        return replace(raw, imu_gyro=np.full((1, 3), 3.0 * (index * 1e-3) ** 2))

    frame = run(pipeline, 0, 200, turning)
    np.testing.assert_allclose(frame.imu_dgyro, 6.0 * (199e-3 - frame.delay), rtol=1e-3)


def test_every_value_has_the_number_of_its_kind():
    robot: Any = SimpleNamespace(dimensions={"n": 2, "k": 1, "m": 1})
    values = column_values(robot, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    assert values.tolist() == [1, 1, 2, 2, 3, 3, 3, 4, 4, 4, 5, 5, 5, 6, 6, 6]


def test_nothing_is_valid_before_the_window_is_full(pipeline):
    almost = run(pipeline, 0, 48)
    assert not (almost.joint_valid.any() or almost.ft_valid.any() or almost.motor_torque_valid)
    assert not almost.q.any() and pipeline.reason == "the filter's window holds 48 of 49 frames"
    full = run(pipeline, 48, 49)
    assert full.joint_valid.all() and full.imu_valid.all() and full.motor_torque_valid
    assert pipeline.reason == ""


def test_measured_velocities_and_accelerations_pass_through_without_delay(pipeline):
    frame = pipeline.step(raw_frame(0, direct=True), 0)
    assert frame.delay == 0.0 and frame.joint_valid.all() and pipeline.reason == ""
    assert frame.dq[0] == 7.0 and frame.ddq[0] == 8.0 and frame.imu_dgyro[0, 0] == 9.0


def test_a_change_of_the_driver_to_positions_only_fills_a_new_window(pipeline):
    run(pipeline, 0, 60)
    pipeline.step(raw_frame(60, direct=True), 60 * MILLISECOND)
    assert not run(pipeline, 61, 70).joint_valid.any()


def drop_sensor(frames: set[int]):
    def change(index: int, raw: RawFrame) -> RawFrame:
        if index not in frames:
            return raw
        ft = raw.ft.copy()
        ft[1] = 0.0
        return replace(raw, ft=ft, ft_valid=np.array([True, False]))

    return change


def test_a_channel_missing_once_is_extrapolated(pipeline):
    frame = run(pipeline, 0, 80, drop_sensor({70}))
    assert frame.ft_valid.all()
    np.testing.assert_allclose(frame.ft, 10.0 * (79e-3 - 0.024), atol=1e-12)


def test_a_channel_missing_twice_is_invalid_until_a_window_of_it_is_measured(pipeline):
    run(pipeline, 0, 71, drop_sensor({70}))
    frame = run(pipeline, 71, 72, drop_sensor({71}))
    assert frame.ft_valid.tolist() == [True, False] and not frame.ft[1].any()
    assert frame.joint_valid.all() and frame.imu_valid.all()
    assert run(pipeline, 72, 72 + 48).ft_valid.tolist() == [True, False]
    frame = run(pipeline, 72 + 48, 72 + 49)
    assert frame.ft_valid.all()
    np.testing.assert_allclose(frame.ft, 10.0 * (120e-3 - 0.024), atol=1e-12)


def test_a_channel_that_never_came_is_never_valid(pipeline):
    assert run(pipeline, 0, 150, drop_sensor(set(range(150)))).ft_valid.tolist() == [True, False]


@pytest.mark.parametrize("lost", [1, 2, 4])
def test_lost_frames_are_bridged_on_a_straight_line(pipeline, lost: int):
    run(pipeline, 0, 60)
    frame = run(pipeline, 60 + lost, 70)
    assert frame.joint_valid.all()
    np.testing.assert_allclose(frame.dq, [1.0, 2.0, 3.0], atol=1e-9)
    assert frame.imu_quat_wxyz is not None and frame.imu_quat_wxyz[0, 3] == 69 - 24


def test_a_long_gap_empties_the_window(pipeline):
    run(pipeline, 0, 60)
    assert not run(pipeline, 65, 66).joint_valid.any()
    assert run(pipeline, 66, 65 + 49).joint_valid.all()


def test_a_stamp_that_jumps_back_empties_the_window(pipeline):
    run(pipeline, 0, 60)
    assert not run(pipeline, 0, 48).joint_valid.any()
    assert run(pipeline, 48, 49).joint_valid.all()


def test_missing_motor_torques_are_flagged_and_cost_nothing_else(pipeline):
    frame = run(pipeline, 0, 60, lambda index, raw: replace(raw, motor_torque=None))
    assert not frame.motor_torque_valid and not frame.motor_torque.any()
    assert frame.joint_valid.all()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("direct", [True, False])
def test_values_that_are_not_finite_count_as_missing(pipeline, value: float, direct: bool):
    for index in range(80):
        raw = raw_frame(index, direct)
        raw.q[1] = value
        frame = pipeline.step(without_nonfinite(raw), index * MILLISECOND)
    assert frame.joint_valid.tolist() == [True, False, True]
    assert np.isfinite(frame.q).all() and frame.q[1] == 0.0
    assert frame.ft_valid.all()


def test_huge_finite_values_are_neither_lost_nor_a_warning(pipeline):
    raw = raw_frame(0, direct=True)
    raw.ft[0, 0] = 1e200
    assert pipeline.step(without_nonfinite(raw), 0).ft[0, 0] == 1e200


def test_frames_do_not_share_memory_with_later_ones(pipeline):
    first = run(pipeline, 0, 60)
    q = first.q.copy()
    run(pipeline, 60, 70)
    np.testing.assert_array_equal(first.q, q)


def test_a_robot_without_inertial_and_force_sensors_works():
    robot: Any = SimpleNamespace(dimensions={"n": 3, "k": 0, "m": 0})
    pipeline = SensorPipeline(robot)
    raw = raw_frame(0)
    none = {"ft": np.zeros((0, 6)), "imu_gyro": np.zeros((0, 3)), "imu_acc": np.zeros((0, 3))}
    flags = {"ft_valid": np.zeros(0, dtype=bool), "imu_valid": np.zeros(0, dtype=bool)}
    raw = replace(raw, imu_quat_wxyz=None, **none, **flags)
    for index in range(49):
        frame = pipeline.step(raw, index * MILLISECOND)
    assert frame.joint_valid.all() and frame.ft.shape == (0, 6)
