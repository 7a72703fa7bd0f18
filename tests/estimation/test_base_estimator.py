"""The base estimator against the plant's truth."""

import numpy as np
import pinocchio as pin
import pytest

from estimation.attitude import AttitudeGains
from estimation.base_estimator import BaseEstimate, BaseEstimator, BaseSample, BaseSettings
from estimation.rotations import rotation_of
from estimation.support_kinematics import SupportKinematics
from robot_sim import Plant

GAINS = AttitudeGains(tilt=0.5, orientation=5.0, heading=2.0, bias=0.5, acceleration_band=2.0)
SETTINGS = BaseSettings(
    gains=GAINS,
    position_gain=2.0,
    loaded_share=0.1,
    pole_lift=0.3,
    position_std=0.01,
    tilt_std=0.005,
    heading_std=0.01,
    linear_std=0.02,
    angular_std=0.01,
)


def sample(plant: Plant, orientation: bool = True) -> BaseSample:
    raw = plant.raw()
    assert raw.imu_quat_wxyz is not None
    return BaseSample(
        q=raw.q,
        dq=plant.truth().dq,
        ft=raw.ft,
        gyro=raw.imu_gyro[0],
        acc=raw.imu_acc[0],
        quat_wxyz=raw.imu_quat_wxyz[0] if orientation else None,
        joint_valid=raw.joint_valid,
        ft_valid=raw.ft_valid,
        imu_valid=True,
    )


def follow(estimator, plant, seconds, orientation=True) -> list[tuple[BaseEstimate, np.ndarray]]:
    """Estimates with their errors: position, rotation, twist (12,)."""
    pairs = []
    for _ in range(int(seconds * 250)):
        for _ in range(4):
            plant.step()
        estimate = estimator.step(sample(plant, orientation), 0.004)
        pairs.append((estimate, errors(estimate, plant.truth())))
    return pairs


def errors(estimate, truth):
    turn = estimate.rotation @ rotation_of(truth.base_quat_wxyz).T
    rotation = 0.5 * np.array(
        [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
    )
    position, twist = estimate.position - truth.base_position, estimate.twist - truth.base_twist
    return np.concatenate([position, rotation, twist])


def test_a_pushed_standing_robot_is_followed_to_millimetres_and_milliradians(robot):
    plant, estimator = Plant(robot), BaseEstimator(robot, "floor", SETTINGS)
    follow(estimator, plant, 0.5)
    plant.push("chest", np.zeros(3), np.array([0.0, 40.0, 0.0]), "world", "half_sine", 0.2)
    worst = np.abs([error for _, error in follow(estimator, plant, 1.5)]).max(axis=0)
    assert worst[:3].max() < 4e-3  # m
    assert worst[3:6].max() < 4e-3  # rad
    assert worst[6:].max() < 0.03  # m/s, rad/s


def test_accelerometer_and_gyro_alone_find_the_tilt_of_a_resting_robot(robot):
    plant, estimator = Plant(robot), BaseEstimator(robot, "floor", SETTINGS)
    final = follow(estimator, plant, 4.0, orientation=False)[-1][1]
    assert np.abs(final[:3]).max() < 5e-3
    assert np.abs(final[3:6]).max() < 5e-3


def test_noisy_sensors_cost_millimetres_and_the_stated_uncertainty_holds(robot):
    plant = Plant(robot, profile="realistic", seed=3)
    estimator = BaseEstimator(robot, "floor", SETTINGS)
    pairs = follow(estimator, plant, 3.0)[-250:]
    rms = np.sqrt(np.mean([error**2 for _, error in pairs], axis=0))
    assert (rms < 3.0 * np.sqrt(np.diag(pairs[-1][0].covariance))).all()


def test_the_gyros_bias_is_learnt_from_the_supports(robot):
    plant, estimator = Plant(robot), BaseEstimator(robot, "floor", SETTINGS)
    bias = np.array([0.01, -0.01, 0.01])
    for _ in range(500):
        for _ in range(4):
            plant.step()
        now = sample(plant)
        estimate = estimator.step(now._replace(gyro=now.gyro + bias), 0.004)
    assert np.abs(estimate.twist[3:] - plant.truth().base_twist[3:]).max() < 3e-3


def test_on_the_pole_the_base_stands_still_where_the_plant_holds_it(robot):
    plant, estimator = Plant(robot, base="fixed"), BaseEstimator(robot, "pole", SETTINGS)
    estimate, error = follow(estimator, plant, 1.0)[-1]
    assert estimate.reason == ""
    assert np.abs(error).max() < 3e-3
    assert not estimate.twist.any()


def test_without_a_loaded_foot_the_estimate_is_invalid(robot):
    plant, estimator = Plant(robot), BaseEstimator(robot, "floor", SETTINGS)
    follow(estimator, plant, 0.1)
    now = sample(plant)
    lifted = estimator.step(now._replace(ft=np.zeros_like(now.ft)), 0.004)
    assert "none of l_sole, r_sole bears load" in lifted.reason
    assert estimator.step(now, 0.004).reason == ""


def test_one_lost_foot_is_borne_by_the_other(robot):
    plant, estimator = Plant(robot), BaseEstimator(robot, "floor", SETTINGS)
    follow(estimator, plant, 0.2)
    now = sample(plant)
    lost = now.ft_valid.copy()
    lost[robot.ft_sensors.index("l_foot_ft")] = False
    estimate = estimator.step(now._replace(ft_valid=lost), 0.004)
    assert estimate.reason == ""
    assert np.abs(errors(estimate, plant.truth())[:3]).max() < 4e-3


@pytest.mark.parametrize(
    ("joint", "imu", "text"),
    [("neck_roll", True, "no data from neck_roll"), ("", False, "no data from head_imu_0")],
)
def test_lost_channels_between_base_and_head_invalidate_the_estimate(robot, joint, imu, text):
    plant, estimator = Plant(robot), BaseEstimator(robot, "floor", SETTINGS)
    now = sample(plant)
    valid = now.joint_valid.copy()
    if joint:
        valid[robot.joints.index(joint)] = False
    assert text in estimator.step(now._replace(joint_valid=valid, imu_valid=imu), 0.004).reason


@pytest.mark.parametrize("frame", ["l_sole", "l_lower_leg"])
def test_a_support_bears_what_its_sensor_reads_also_beyond_a_joint(robot, frame):
    generator = np.random.default_rng(4)
    q, reading = generator.normal(0.0, 0.4, robot.n), generator.normal(0.0, 30.0, 6)
    kinematics = SupportKinematics(robot, (frame,))
    kinematics.update(q, np.zeros(robot.n))
    sensor = robot.subtrees[robot.subtree_of(frame)].ft_in
    ft = np.zeros((len(robot.ft_sensors), 6))
    ft[sensor] = reading
    load = kinematics.load(0, kinematics.support(0), ft)
    tree = robot.tree
    data = tree.model.createData()
    pin.framesForwardKinematics(tree.model, data, tree.configuration(q))
    base_m_sensor = data.oMf[tree.frame_id(robot.ft_frames[sensor])]
    base_m_support = data.oMf[tree.frame_id(frame)]
    np.testing.assert_allclose(load.force, -base_m_sensor.rotation @ reading[:3], atol=1e-9)
    if frame not in robot.soles:  # whose centre is held inside the sole
        wrench = base_m_sensor.act(pin.Force(-reading))
        about = wrench.angular - np.cross(load.center, wrench.linear)
        np.testing.assert_allclose((base_m_support.rotation.T @ about)[:2], 0.0, atol=1e-9)


def test_without_supports_there_is_no_base_estimate(robot):
    plant, estimator = Plant(robot), BaseEstimator(robot, "none", SETTINGS)
    assert estimator.step(sample(plant), 0.004).reason == "no support"


def test_an_unknown_support_is_refused_with_what_exists(robot):
    with pytest.raises(LookupError, match="no support 'flor'; there are: floor, pole, none"):
        BaseEstimator(robot, "flor", SETTINGS)
