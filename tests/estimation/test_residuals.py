"""Residuals against the papers' literal formulas, finite differences and the plant."""

import numpy as np
import pinocchio as pin
import pytest

from estimation.residual.fixed_base_residual import FixedBaseResidual
from estimation.residual.floating_terms import floating_terms
from estimation.residual.momentum_filter import MomentumFilter
from estimation.residual.residual_model import residual_model
from estimation.residual.residuals import FloatingResiduals
from estimation.sensor_pipeline import SensorPipeline
from robot_model import Robot
from robot_model.messages import SensorFrame
from robot_sim import Plant


def random_state(model: pin.Model, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    q = pin.neutral(model)
    q[7:] = rng.uniform(-1.0, 1.0, model.nq - 7)
    q[3:7] = pin.Quaternion(pin.exp3(rng.normal(size=3))).coeffs()
    return q, rng.normal(size=model.nv)


def terms_at(model: pin.Model, q: np.ndarray, v: np.ndarray, force: np.ndarray):
    data = model.createData()
    mass = pin.crba(model, data, q).copy()
    coriolis = pin.computeCoriolisMatrix(model, data, q, v).copy()
    return floating_terms(mass, coriolis, v, force, np.zeros(model.nv)), mass, coriolis


def literal_internal(mass, coriolis, mass_rate, v, force):
    """R eqs. (9), (11), (13) with all matrices formed."""
    i0, f = mass[:6, :6], mass[:6, 6:]
    di0, df, dh = mass_rate[:6, :6], mass_rate[:6, 6:], mass_rate[6:, 6:]
    inverse = np.linalg.inv(i0)
    h_fb = mass[6:, 6:] - f.T @ inverse @ f
    dh_fb = dh - df.T @ inverse @ f - f.T @ inverse @ df + f.T @ inverse @ di0 @ inverse @ f
    bias = coriolis @ v - force
    c_fb = bias[6:] - f.T @ inverse @ bias[:6]
    return h_fb @ v[6:], dh_fb @ v[6:] - c_fb


def mass_rate_at(model: pin.Model, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    step, data = 1e-6, model.createData()
    after = pin.crba(model, data, pin.integrate(model, q, v * step)).copy()
    return (after - pin.crba(model, data, pin.integrate(model, q, -v * step))) / (2 * step)


def test_internal_terms_equal_the_literal_formulas_with_all_matrices(robot: Robot) -> None:
    model, rng = robot.tree.model, np.random.default_rng(1)
    for _ in range(20):
        q, v = random_state(model, rng)
        force = rng.normal(size=model.nv)
        terms, mass, coriolis = terms_at(model, q, v, force)
        literal = literal_internal(mass, coriolis, coriolis + coriolis.T, v, force)
        np.testing.assert_allclose(terms[0, model.nv :], literal[0], atol=1e-11)
        np.testing.assert_allclose(terms[1, model.nv :], literal[1], atol=1e-11)
        measured = literal_internal(mass, coriolis, mass_rate_at(model, q, v), v, force)
        np.testing.assert_allclose(terms[1, model.nv :], measured[1], atol=1e-6)


def test_momenta_change_as_their_rates_say_when_nothing_is_unknown(robot: Robot) -> None:
    model, rng = robot.tree.model, np.random.default_rng(2)
    data, step = model.createData(), 1e-6
    for _ in range(5):
        q, v = random_state(model, rng)
        torque = np.concatenate((np.zeros(6), rng.normal(size=model.nv - 6)))
        acceleration = pin.aba(model, data, q, v, torque)
        force = torque - pin.computeGeneralizedGravity(model, data, q)
        now = terms_at(model, q, v, force)[0]
        momenta = [
            terms_at(model, pin.integrate(model, q, h * v), v + h * acceleration, force)[0]
            for h in (-step, step)
        ]
        change = (momenta[1][0] - momenta[0][0]) / (2 * step)
        np.testing.assert_allclose(change, now[1], atol=2e-5)


def test_internal_terms_do_not_depend_on_linear_velocity_of_the_base(robot: Robot) -> None:
    model, rng = robot.tree.model, np.random.default_rng(3)
    model_without_gravity = pin.Model(model)
    q, v = random_state(model_without_gravity, rng)
    moved = v + np.concatenate((rng.normal(size=3), np.zeros(model.nv - 3)))
    force = np.zeros(model.nv)
    first, second = (terms_at(model, q, x, force)[0] for x in (v, moved))
    np.testing.assert_allclose(first[0, model.nv :], second[0, model.nv :], atol=1e-12)
    np.testing.assert_allclose(first[1, model.nv :], second[1, model.nv :], atol=1e-11)


def test_the_filter_is_exact_for_a_constant_unknown_force_at_every_gain_and_step() -> None:
    for gain in (0.1, 25.0, 1e4):
        for period in (1e-3, 0.1, 2.0):
            observer = MomentumFilter(1, gain)
            for k in range(6):
                momentum = np.array([7.0 + 3.0 * k * period])  # rate 1 known, 2 unknown
                residual = observer.step(momentum, np.array([1.0]), period)[0]
                assert residual == pytest.approx(-2.0 * np.expm1(-gain * k * period), abs=1e-9)


def test_the_filter_changes_gains_without_a_jump_and_restarts_from_zero() -> None:
    observer = MomentumFilter(2, 10.0)
    for k in range(50):
        observer.step(np.full(2, 1e-3 * k), np.zeros(2), 1e-3)
    before = observer.residual.copy()
    observer.gain = np.array([1.0, 500.0])
    np.testing.assert_array_equal(observer.residual, before)
    observer.reset()
    assert not observer.step(np.full(2, 9.0), np.zeros(2), 1e-3).any()
    with pytest.raises(ValueError, match="positive"):
        observer.gain = 0.0


def test_the_residual_model_holds_the_robot_without_its_feet(robot: Robot) -> None:
    layout = residual_model(robot, "floor")
    feet = sum(robot.bodies[link].mass for s in robot.subtrees[-2:] for link in s.links)
    assert layout.sensors == (4, 5)
    assert pin.computeTotalMass(layout.model) == pytest.approx(robot.mass - feet)


def exact_frame(plant: Plant) -> SensorFrame:
    return SensorPipeline(plant.robot).step(plant.raw(), plant.time)


def run_push(plant: Plant, residuals: FloatingResiduals, seconds: float) -> None:
    for _ in range(round(seconds * 1000)):
        plant.step()
        raw = exact_frame(plant)
        residuals.step(
            raw.q, raw.dq, raw.motor_torque, raw.ft, raw.imu_gyro[0], raw.imu_acc[0], 1e-3
        )


def expected(plant: Plant, link: str, point: np.ndarray, force: np.ndarray):
    """External wrench in base axes, and internal torques by R eq. (12), of a force in world."""
    robot = plant.robot
    layout = residual_model(robot, "floor")
    model, data = layout.model, layout.model.createData()
    truth = plant.truth()
    q = pin.neutral(model)
    w, x, y, z = truth.base_quat_wxyz
    q[3:7] = x, y, z, w
    q[layout.joint_q] = truth.q
    mass = pin.crba(model, data, q).copy()
    frame = robot.tree.frame_id(link)
    pin.framesForwardKinematics(model, data, q)
    jacobian = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)
    arm = data.oMf[frame].rotation @ point
    at_point = jacobian[:3] - pin.skew(arm) @ jacobian[3:]
    whole = at_point.T @ force
    internal = whole[6:] - mass[6:, :6] @ np.linalg.solve(mass[:6, :6], whole[:6])
    return whole[:6], internal[layout.joint_v - 6]


def test_residuals_of_a_pushed_standing_robot_are_the_push(robot: Robot) -> None:
    plant = Plant(robot)
    residuals = FloatingResiduals(robot, "floor", 100.0, 100.0)
    run_push(plant, residuals, 0.3)
    quiet = residuals.sample
    assert np.abs(quiet.external).max() < 0.05
    assert np.abs(quiet.internal).max() < 0.02
    point, force = np.array([0.0, 0.0, 0.1]), np.array([6.0, 12.0, -8.0])
    plant.push("chest", point, force, frame="world")
    run_push(plant, residuals, 0.4)
    external, internal = expected(plant, "chest", point, force)
    np.testing.assert_allclose(residuals.sample.external, external, atol=0.15)
    np.testing.assert_allclose(residuals.sample.internal, internal, atol=0.05)


def test_an_unmeasured_support_is_refused_with_its_name(robot: Robot) -> None:
    with pytest.raises(ValueError, match="pole"):
        FloatingResiduals(robot, "pole")


def test_the_classical_residual_of_a_robot_on_the_pole_is_the_push(robot: Robot) -> None:
    plant = Plant(robot, base="fixed")
    observer = FixedBaseResidual(robot, 100.0)
    model, data = robot.tree.model, robot.tree.model.createData()
    point, force = np.array([0.0, 0.0, 0.05]), np.array([5.0, -3.0, 8.0])
    for k in range(700):
        if k == 300:
            assert np.abs(observer.residual).max() < 0.01
            plant.push("l_forearm", point, force)
        plant.step()
        raw, truth = exact_frame(plant), plant.truth()
        w, x, y, z = truth.base_quat_wxyz
        up_base = pin.Quaternion(w, x, y, z).matrix()[2]
        observer.step(raw.q, raw.dq, raw.motor_torque, up_base, 1e-3)
    q = robot.tree.configuration(truth.q)
    frame = robot.tree.frame_id("l_forearm")
    jacobian = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL)
    torque = (jacobian[:3] - pin.skew(point) @ jacobian[3:]).T @ force
    np.testing.assert_allclose(observer.residual, torque[robot.tree.joint_v], atol=0.03)


def test_residuals_evaluated_at_every_fourth_sample_are_the_same(robot: Robot) -> None:
    plant = Plant(robot)
    every, fourth = (FloatingResiduals(robot, "floor", 50.0, 50.0) for _ in range(2))
    for tick in range(400):
        if tick == 200:
            plant.push("chest", np.zeros(3), np.array([0.0, 15.0, 0.0]), frame="world")
        plant.step()
        frame = exact_frame(plant)
        imu = frame.imu_gyro[0], frame.imu_acc[0], 1e-3
        every.step(frame.q, frame.dq, frame.motor_torque, frame.ft, *imu)
        fourth.add(frame.motor_torque, frame.ft, *imu)
        if tick % 4 == 3:
            fourth.evaluate(frame.q, frame.dq)
    np.testing.assert_allclose(fourth.sample.external, every.sample.external, atol=0.1)
    np.testing.assert_allclose(fourth.sample.internal, every.sample.internal, atol=0.03)


def test_many_samples_at_once_give_the_numbers_of_one_by_one(robot: Robot) -> None:
    rng, size = np.random.default_rng(5), 300  # 0.6 s: the frame falls anew twice
    n, k = robot.n, len(robot.ft_sensors)
    shapes = {"torque": (n,), "ft": (k, 6), "gyro": (3,), "acc": (3,), "q": (n,), "dq": (n,)}
    torque, ft, gyro, acc, q, dq = (rng.normal(size=(size, *s)) for s in shapes.values())
    singly, together = FloatingResiduals(robot), FloatingResiduals(robot)
    expected = []
    for i in range(size):
        singly.add(torque[i], ft[i], gyro[i], acc[i], 2e-3)
        if i % 3 == 1:
            singly.evaluate(q[i], dq[i])
            expected.append(singly.values)
    found = []
    for block in np.split(np.arange(size), [100, 101, 240]):
        due = np.flatnonzero(block % 3 == 1)
        rows, stacked = block[due], (torque[block], ft[block], gyro[block], acc[block])
        periods = [2e-3] * len(block)
        found += list(together.evaluate_over(periods, stacked, due, q[rows], dq[rows]))
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)
