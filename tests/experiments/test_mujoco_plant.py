"""MuJoCo as a plant: the same robot, rotors and friction included, in other physics."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from experiments.mujoco_plant import MujocoPlant, mujoco
from robot_model import Robot, load_robot
from robot_sim import Plant


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("icub")


def test_its_mass_matrix_holds_the_coupled_rotors(robot: Robot) -> None:
    plant = MujocoPlant(robot, "fixed")
    mass = np.zeros((plant.model.nv, plant.model.nv))
    mujoco.mj_fullM(plant.model, plant.data, mass)
    address = [plant.model.joint(name).dofadr[0] for name in robot.joints]
    tree = robot.tree
    ours = pin.crba(tree.model, tree.model.createData(), tree.configuration(robot.home))
    ours = np.triu(ours) + np.triu(ours, 1).T
    expected = ours[np.ix_(tree.joint_v, tree.joint_v)] + robot.rotor_inertia
    np.testing.assert_allclose(mass[np.ix_(address, address)], expected, atol=1e-6)


def test_it_stands_where_our_plant_stands(robot: Robot) -> None:
    plants = MujocoPlant(robot, "free"), Plant(robot, "free")
    for plant in plants:
        for _ in range(600):
            plant.step()
        assert not plant.fallen
    theirs, ours = (plant.readings for plant in plants)
    np.testing.assert_allclose(theirs.q, ours.q, atol=0.02)  # rad; floors differ
    np.testing.assert_allclose(theirs.acceleration, ours.acceleration, atol=1.0)
    weight = sum(wrench[2] for wrench in plants[0].support_wrenches().values())
    assert weight == pytest.approx(9.81 * robot.mass, rel=0.05)


def test_a_push_is_felt_by_the_sensors_as_in_our_plant(robot: Robot) -> None:
    point, force = np.array([0.01, 0.0, 0.0]), np.array([0.0, 0.0, 8.0])
    changes = []
    for kind in (MujocoPlant, Plant):
        plant = kind(robot, "fixed")
        before = [_after(plant, 300).ft]
        plant.push("l_hand", point, force, profile="ramp", rise=0.05)
        changes.append(_after(plant, 60).ft - before[0])
    arm = robot.ft_sensors.index("l_arm_ft")
    assert np.linalg.norm(changes[0][arm, :3]) > 3.0
    np.testing.assert_allclose(*(change[arm] for change in changes), atol=0.3)


def test_coulomb_friction_opposes_the_motion_of_its_joints(robot: Robot) -> None:
    rough = replace(robot, coulomb=np.full(robot.n, 0.2))
    plant = MujocoPlant(rough, "fixed", "realistic_friction")
    goal = robot.home.copy()
    elbow = robot.joints.index("l_elbow")
    goal[elbow] += 0.3
    plant.boards.command("position", goal)
    exact = _after(plant, 150)
    rotors = robot.rotor_inertia @ exact.ddq
    dry = exact.motor_torque - rotors - robot.viscous * exact.dq - exact.link_torque
    assert exact.dq[elbow] > 0.05
    assert dry[elbow] == pytest.approx(0.2, abs=0.01)
    assert np.abs(dry).max() < 0.2 + 0.01


def _after(plant, ticks: int):
    for _ in range(ticks):
        plant.step()
    return plant.readings
