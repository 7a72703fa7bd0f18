"""Inertial sensors of a description: what each measures, and a variant that extends another."""

import numpy as np
import pytest
import yaml

from robot_model import DescriptionError, load_robot
from robot_model.description import DESCRIPTIONS, description_text
from robot_sim import Plant
from robot_sim.noise import load_profile


@pytest.fixture(scope="module")
def robot():
    return load_robot("icub_inertial")


def changed(tmp_path, **keys):
    file = tmp_path / "variant.yaml"
    file.write_text(yaml.safe_dump({"extends": str(DESCRIPTIONS / "icub.yaml"), **keys}))
    return file


def test_the_variant_is_icub_with_more_inertial_sensors(robot):
    plain = load_robot("icub")
    assert robot.imus[0] == plain.imus[0] and plain.imus == ("head_imu_0",)
    assert robot.joints == plain.joints and robot.model_hash == plain.model_hash
    assert robot.mass == plain.mass and robot.links == plain.links
    assert len(robot.imus) == robot.dimensions["m"] == 23


def test_a_sensor_that_is_no_link_of_the_urdf_hangs_where_its_element_says(robot):
    link, placement = robot.frame("chest_ems_acc_eb1")
    assert link == "chest"
    np.testing.assert_allclose(placement.translation, [0.0647855, 0.064043, -0.0647091], atol=1e-9)


def test_masses_drawn_wrong_by_a_seed_are_those_of_the_plain_robot(robot):
    ours, plain = robot.perturbed(3, 0.02), load_robot("icub").perturbed(3, 0.02)
    assert ours.bodies["chest"].mass == plain.bodies["chest"].mass != robot.bodies["chest"].mass


@pytest.mark.parametrize(
    ("imus", "problem"),
    [
        ([{"name": "head_imu_0", "gyro": False}], "must have a gyro and an accelerometer"),
        (["head_imu_0", {"name": "chest", "gyro": False, "accelerometer": False}], "nothing"),
        (["head_imu_0", "chest_acc"], "unknown URDF link or frame 'chest_acc'"),
        (["head_imu_0", {"name": "chest", "nose": 1}], "nose: unknown key"),
        (["head_imu_0", {"name": "chest", "noise": 0}], "noise: input should be greater than 0"),
    ],
)
def test_inertial_sensors_that_cannot_be_are_refused(tmp_path, imus, problem):
    with pytest.raises(DescriptionError, match=problem):
        load_robot(changed(tmp_path, imus=imus))


def test_a_description_that_extends_nothing_or_itself_is_refused(tmp_path):
    for base, problem in (("nowhere.yaml", "No such file"), ("variant.yaml", "this file itself")):
        file = changed(tmp_path)
        file.write_text(f"extends: {base}\n")
        with pytest.raises(DescriptionError, match=problem):
            load_robot(file)


def test_the_text_of_an_extended_description_stands_by_itself(robot, tmp_path):
    file = tmp_path / "alone.yaml"
    file.write_text(description_text(robot.source))
    assert load_robot(file).imus == robot.imus
    assert description_text(DESCRIPTIONS / "icub.yaml") == (DESCRIPTIONS / "icub.yaml").read_text()


def test_the_plant_reads_what_each_sensor_measures(robot):
    plant = Plant(robot, base="fixed", profile="realistic", seed=2)
    raw, sensors = plant.raw(), robot.inertial_sensors
    assert raw.imu_acc.shape == (len(sensors), 3)
    assert raw.imu_quat_wxyz is not None
    np.testing.assert_array_equal(raw.imu_quat_wxyz[1:], [[1.0, 0.0, 0.0, 0.0]] * 22)
    for sensor, gyro, acc in zip(sensors, raw.imu_gyro, raw.imu_acc, strict=True):
        assert gyro.any() == sensor.gyro and acc.any() == sensor.accelerometer


def test_the_head_reads_the_same_with_and_without_the_other_sensors(robot):
    exact = [Plant(load_robot(name), base="fixed").raw() for name in ("icub", "icub_inertial")]
    np.testing.assert_array_equal(exact[0].imu_acc[0], exact[1].imu_acc[0])
    np.testing.assert_array_equal(exact[0].imu_quat_wxyz[0], exact[1].imu_quat_wxyz[0])


def test_noise_factors_scale_the_errors_of_their_sensors(robot):
    noise = Plant(robot, base="fixed", profile="realistic").noise
    errors = []
    for _ in range(3000):
        noise.draw()
        errors.append(noise.errors["accelerometer"].copy())
    white = np.std(errors, axis=0).mean(axis=1)
    factor = [s.noise * s.accelerometer for s in robot.inertial_sensors]
    np.testing.assert_allclose(white, 0.02 * np.array(factor), rtol=0.05)
    assert load_profile("realistic").accelerometer.white == 0.02
