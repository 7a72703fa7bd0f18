"""Rows of touches, their covariance and the places they tell, with exact sensors."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from estimation.contact.contact_rows import ContactRows
from estimation.contact.localiser import Localiser
from estimation.contact.row_covariance import RowCovariance
from estimation.sensor_pipeline import SensorPipeline
from robot_model import Robot
from robot_model.messages import SensorFrame
from robot_sim import Plant

TOUCHES = {
    "chest": [3.0, -8.0, 2.0],
    "l_forearm": [0.0, 6.0, 4.0],
    "r_hand": [5.0, 0.0, -3.0],
    "l_lower_leg": [-4.0, 4.0, 0.0],
    "r_upper_leg": [0.0, -5.0, 5.0],
}
POINT = np.array([0.01, -0.02, 0.03])


def exact_frame(plant: Plant) -> SensorFrame:
    return SensorPipeline(plant.robot).step(plant.raw(), plant.time)


def shaken(robot: Robot, touches: dict[str, list[float]], base: str = "free") -> Plant:
    """Return a plant 30 ms after forces began to act, while it accelerates hard."""
    plant = Plant(robot, base=base)  # type: ignore[arg-type]
    rng = np.random.default_rng(5)
    plant.command(position=robot.home + 0.1 * rng.normal(size=robot.n))
    for link, force in touches.items():
        plant.push(link, POINT, np.array(force))
    for _ in range(30):
        plant.step()
    return plant


def true_wrenches(rows: ContactRows, touches: dict[str, list[float]]) -> np.ndarray:
    """Net wrench of the touches on each sub-tree, in the axes and origin of the IMU."""
    robot = rows.robot
    places = dict(zip(robot.links, rows.place_links(), strict=True))
    result = np.zeros((len(robot.subtrees), 6))
    for link, force in touches.items():
        at_point = pin.Force(np.array(force), np.cross(POINT, force))
        result[robot.subtree_of(link)] += places[link].act(at_point).vector
    return result


@pytest.mark.parametrize("base", ["free", "fixed"])
def test_the_wrench_on_every_subtree_is_exact_on_a_moving_robot(robot: Robot, base: str) -> None:
    touches = TOUCHES | ({"l_foot": [2.0, 3.0, 1.0]} if base == "fixed" else {})
    if base == "fixed":
        del touches["chest"]  # the pole takes what touches its own sub-tree
    plant = shaken(robot, touches, base)
    rows = ContactRows(robot, "floor" if base == "free" else "pole")
    wrenches = rows.wrenches(rows.update(exact_frame(plant)))
    assert np.abs(plant.truth().ddq).max() > 1.0
    np.testing.assert_allclose(wrenches, true_wrenches(rows, touches), atol=1e-8)


def test_rows_are_the_transposed_jacobian_times_the_touch(robot: Robot) -> None:
    touch = {"l_forearm": [0.0, 6.0, 4.0]}
    rows = ContactRows(robot)
    values = rows.update(exact_frame(shaken(robot, touch)))
    wrench = true_wrenches(rows, touch).sum(axis=0)
    expected = (rows.layout.rows_of("l_forearm")[:, None] * rows.jacobian) @ wrench
    np.testing.assert_allclose(values, expected, atol=1e-8)


def test_what_is_made_blind_no_longer_disturbs_the_other_limbs(robot: Robot) -> None:
    rows = ContactRows(robot)
    values = rows.update(exact_frame(shaken(robot, TOUCHES))).copy()
    arm = robot.subtree_of("l_forearm")
    others = [robot.subtree_of(link) for link in TOUCHES if link != "l_forearm"]
    removed = rows.removing(others)
    values = rows.remove(values, removed)
    only = {"l_forearm": TOUCHES["l_forearm"]}
    wrench = true_wrenches(rows, only)[arm]
    expected = (rows.layout.rows_of("l_forearm")[:, None] * rows.jacobian) @ wrench
    np.testing.assert_allclose(values[removed.active], expected[removed.active], atol=1e-8)


def test_errors_of_accelerations_spread_over_the_rows_as_the_covariance_says(
    robot: Robot,
) -> None:
    rows = ContactRows(robot)
    frame = exact_frame(shaken(robot, {}))
    exact = rows.update(frame).copy()
    covariance = RowCovariance(rows)
    covariance.update(frame)
    noise, rng = covariance.noise, np.random.default_rng(7)
    torque = np.hypot(noise.torque, noise.friction)
    samples = []
    for _ in range(3000):
        ft_error = rng.normal(size=frame.ft.shape) * np.repeat([noise.ft_force, noise.ft_moment], 3)
        shaken_frame = replace(
            frame,
            ddq=frame.ddq + noise.joint_acceleration * rng.normal(size=robot.n),
            imu_acc=frame.imu_acc + noise.acceleration * rng.normal(size=(1, 3)),
            imu_dgyro=frame.imu_dgyro + noise.angular_acceleration * rng.normal(size=(1, 3)),
            motor_torque=frame.motor_torque + torque * rng.normal(size=robot.n),
            ft=frame.ft + ft_error,
        )
        samples.append(rows.update(shaken_frame) - exact)
    spread = np.std(samples, axis=0)[6:]
    expected = np.sqrt(np.maximum(np.diag(covariance.matrix)[6:], 0.0))
    active = rows.removed.active[6:]
    np.testing.assert_allclose(spread[active], expected[active], rtol=0.08)


def test_a_lost_sensor_counts_for_nothing(robot: Robot) -> None:
    rows = ContactRows(robot)
    frame = exact_frame(shaken(robot, {}))
    rows.update(frame)
    covariance = RowCovariance(rows)
    valid = frame.ft_valid.copy()
    valid[0] = False
    covariance.update(replace(frame, ft_valid=valid))
    units = np.eye(len(covariance.matrix))[rows.layout.inlets[1]]
    assert np.square(covariance.whiten(units)).sum(axis=1).max() < 1e-5


@pytest.mark.parametrize("link", ["chest", "l_forearm", "r_upper_leg", "head"])
def test_a_touch_on_the_surface_is_found_where_it_is(robot: Robot, link: str) -> None:
    surface = robot.load_surface()
    body = [body.name for body in surface.bodies].index(link)
    candidates = np.flatnonzero(surface.body == body)
    index = int(candidates[len(candidates) // 3])
    plant = Plant(robot)
    plant.push(link, surface.points[index], -15.0 * surface.normals[index])
    for _ in range(40):
        plant.step()
    rows = ContactRows(robot)
    frame = exact_frame(plant)
    touch = rows.update(frame)
    covariance = RowCovariance(rows)
    covariance.update(frame)
    found = Localiser(rows).locate(touch, covariance, robot.subtree_of(link))
    best = found.hypotheses[0]
    assert best.links[0] == link
    np.testing.assert_allclose(best.point, surface.points[index], atol=2e-3)
    np.testing.assert_allclose(best.force, -15.0 * surface.normals[index], atol=0.1)
    assert sum(h.probability for h in found.hypotheses) + found.none_probability <= 1.0 + 1e-9


def test_a_pure_moment_is_explained_by_no_point(robot: Robot) -> None:
    rows = ContactRows(robot)
    frame = exact_frame(Plant(robot))
    values = rows.update(frame)
    bears = rows.layout.rows_of("l_forearm")
    values = values + (bears[:, None] * rows.jacobian) @ np.array([0.0, 0, 0, 0, 0, 2.0])
    covariance = RowCovariance(rows)
    covariance.update(frame)
    found = Localiser(rows).locate(values, covariance, robot.subtree_of("l_forearm"))
    assert found.none_probability > 0.99
