"""The torque observer against inverse dynamics with known external wrenches, and the plant."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from estimation.torque_observer import TorqueObserver
from robot_model import Robot, build_tree
from robot_sim import Plant
from tests.estimation.observer_states import ObserverInput, random_input


class KnownMotion:
    """A free robot in random motion, with a known wrench at one point of each sub-tree."""

    def __init__(self, robot: Robot, contacts, seed: int):
        rng = np.random.default_rng(seed)
        self.tree = build_tree(robot, robot.base_link, cut=True)
        self.model, self.data = self.tree.model, self.tree.model.createData()
        self.q, self.dq, self.ddq = (rng.normal(size=robot.n) for _ in range(3))
        pose = pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(size=3))
        self.wrench = 10.0 * rng.normal(size=(len(contacts), 6))
        self.configuration = self.tree.configuration(self.q, pose)
        motion = (
            self.configuration,
            self.tree.velocity(self.dq, rng.normal(size=6)),
            self.tree.velocity(self.ddq, rng.normal(size=6)),
        )
        self._balance(contacts[0], pin.rnea(self.model, self.data, *motion, self._forces(contacts)))
        tau = pin.rnea(self.model, self.data, *motion, self._forces(contacts))
        assert np.abs(tau[:6]).max() < 1e-9
        self.torque = tau[self.tree.joint_v]
        self.ft = tau[self.tree.cut_v] * self.tree.cut_sign[:, None]
        # Proper acceleration: as if the free world were accelerated upwards.
        self.model.gravity = pin.Motion.Zero()
        pin.forwardKinematics(self.model, self.data, *motion)
        self.up = np.array([0.0, 0.0, 9.81])

    def _balance(self, contact, tau: np.ndarray) -> None:
        """Let the root's contact bear what the free base lacks for this motion."""
        pin.framesForwardKinematics(self.model, self.data, self.configuration)
        base_m_contact = self.data.oMi[1].actInv(
            self.data.oMf[self.tree.frame_id(contact.link)] * contact.placement
        )
        self.wrench[0] += base_m_contact.actInv(pin.Force(tau[:6])).vector

    def _forces(self, contacts) -> pin.StdVec_Force:
        forces = pin.StdVec_Force([pin.Force.Zero() for _ in range(self.model.njoints)])
        for contact, wrench in zip(contacts, self.wrench, strict=True):
            frame = self.model.frames[self.tree.frame_id(contact.link)]
            joint_m_contact = frame.placement * contact.placement
            forces[frame.parentJoint] += joint_m_contact.act(pin.Force(wrench))
        return forces

    def seen_from(self, imu: str) -> ObserverInput:
        """Return the observer's input with the inertial sensor at a frame."""
        frame = self.tree.frame_id(imu)
        pin.updateFramePlacement(self.model, self.data, frame)
        local = pin.ReferenceFrame.LOCAL
        twist = pin.getFrameVelocity(self.model, self.data, frame, local)
        classical = pin.getFrameClassicalAcceleration(self.model, self.data, frame, local)
        acc = classical.linear + self.data.oMf[frame].rotation.T @ self.up
        state = (self.q, self.dq, self.ddq, self.ft, twist.angular, acc, classical.angular)
        return ObserverInput(*state)


@pytest.mark.parametrize("imu", ["head_imu_0", "root_link", "l_foot", "r_hand_dh_frame"])
def test_known_wrenches_and_torques_come_back_wherever_the_inertial_sensor_sits(robot, imu):
    observer = TorqueObserver(replace(robot, imus=(imu,)))
    for seed in range(5):
        motion = KnownMotion(robot, observer.contacts, seed)
        estimate = observer.step(*motion.seen_from(imu))
        np.testing.assert_allclose(estimate.wrench, motion.wrench, atol=1e-9)
        np.testing.assert_allclose(estimate.torque, motion.torque, atol=1e-9)


def test_contacts_moved_at_run_time_bear_the_known_wrenches(robot):
    observer = TorqueObserver(robot)
    touches = [("l_upper_arm", [0.01, 0.02, -0.03]), ("root_link", [0.1, 0.0, 0.05])]
    touches.append(("r_upper_leg", [0.0, 0.04, -0.1]))
    observer.set_contacts([(link, np.array(point)) for link, point in touches])
    motion = KnownMotion(robot, observer.contacts, 3)
    estimate = observer.step(*motion.seen_from(robot.imus[0]))
    np.testing.assert_allclose(estimate.wrench, motion.wrench, atol=1e-9)
    np.testing.assert_allclose(estimate.torque, motion.torque, atol=1e-9)


def test_subtree_wrenches_do_not_depend_on_where_the_contacts_are(robot):
    observer = TorqueObserver(robot)
    state = random_input(robot, np.random.default_rng(1))
    before = observer.step(*state).subtree_wrench
    observer.set_contacts([("l_forearm", np.array([0.0, 0.0, 0.05])), ("head", np.zeros(3))])
    after = observer.step(*state).subtree_wrench
    np.testing.assert_allclose(after, before, atol=1e-12)


def test_moving_the_contacts_back_restores_the_first_answer(robot):
    observer = TorqueObserver(robot)
    state = random_input(robot, np.random.default_rng(2))
    before = observer.step(*state)
    observer.set_contacts([("l_forearm", np.zeros(3))])
    observer.set_contacts([])
    after = observer.step(*state)
    np.testing.assert_array_equal(after.wrench, before.wrench)
    np.testing.assert_array_equal(after.torque, before.torque)


def test_results_are_not_overwritten_by_the_next_sample(robot):
    observer = TorqueObserver(robot)
    rng = np.random.default_rng(4)
    first = observer.step(*random_input(robot, rng))
    copies = [np.copy(getattr(first, name)) for name in first.__slots__]
    observer.step(*random_input(robot, rng))
    for name, copy in zip(first.__slots__, copies, strict=True):
        np.testing.assert_array_equal(getattr(first, name), copy)


def test_an_offset_is_taken_off_the_readings(robot):
    observer = TorqueObserver(robot)
    state = random_input(robot, np.random.default_rng(5))
    clean = observer.step(*state)
    observer.offset = np.arange(36.0).reshape(6, 6)
    biased = observer.step(*state._replace(ft=state.ft + observer.offset))
    np.testing.assert_allclose(biased.wrench, clean.wrench, atol=1e-9)
    np.testing.assert_allclose(biased.measured, state.ft, atol=1e-12)


def observe(observer: TorqueObserver, plant: Plant):
    raw = plant.raw()
    assert raw.dq is not None and raw.ddq is not None and raw.imu_dgyro is not None
    imu = (raw.imu_gyro[0], raw.imu_acc[0], raw.imu_dgyro[0])
    return observer.step(raw.q, raw.dq, raw.ddq, raw.ft, *imu)


def relative(ours: np.ndarray, truth: np.ndarray) -> float:
    return np.abs(ours - truth).max() / max(1.0, np.abs(truth).max())


@pytest.mark.parametrize("link", ["l_hand", "r_hand", "l_lower_leg", "r_lower_leg", "chest"])
def test_a_push_on_the_default_contacts_link_equals_the_plants_truth(robot, link):
    plant, observer = Plant(robot), TorqueObserver(robot)
    force = np.array([6.0, -4.0, 3.0])
    plant.push(link, np.array([0.01, 0.02, 0.03]), force)
    for _ in range(150):
        plant.step()
    estimate, truth = observe(observer, plant), plant.truth()
    assert relative(estimate.torque, truth.link_torque) < 1e-6
    for frame, wrench in zip(truth.support_frames, truth.support_wrench, strict=True):
        ours = estimate.wrench[robot.subtree_of(frame)]
        assert relative(ours, wrench) < 1e-6
    pushed = robot.subtree_of(link)
    contact = observer.contacts[pushed]
    axes = contact.placement.rotation
    assert relative(axes @ estimate.wrench[pushed, :3], force) < 1e-6


def test_a_push_at_a_given_point_is_a_pure_force_there(robot):
    plant, observer = Plant(robot), TorqueObserver(robot)
    point = np.array([0.0, 0.01, -0.08])
    plant.push("l_forearm", point, np.array([0.0, 7.0, 2.0]))
    observer.set_contacts([("l_forearm", point)])
    for _ in range(80):
        plant.step()
    estimate, truth = observe(observer, plant), plant.truth()
    wrench = estimate.wrench[robot.subtree_of("l_forearm")]
    np.testing.assert_allclose(wrench, [0.0, 7.0, 2.0, 0.0, 0.0, 0.0], atol=1e-6)
    assert relative(estimate.torque, truth.link_torque) < 1e-6


def test_on_the_pole_the_base_bears_the_robot(robot):
    plant, observer = Plant(robot, base="fixed"), TorqueObserver(robot, support="pole")
    for _ in range(100):
        plant.step()
    estimate, truth = observe(observer, plant), plant.truth()
    assert relative(estimate.torque, truth.link_torque) < 1e-6
    assert relative(estimate.wrench[0], truth.support_wrench[0]) < 1e-6
    assert np.abs(estimate.wrench[1:]).max() < 1e-6
