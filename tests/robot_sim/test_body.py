"""The body's own bookkeeping: views of Pinocchio's memory, the inertia of the rotors."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from robot_sim.body import Body, ExternalForces
from robot_sim.joint_rows import joint_rows


def test_joint_rows_are_pinocchios_own_placements_and_motions(robot):
    model = robot.tree.model
    data = model.createData()
    placements, twists = joint_rows(data.oMi), joint_rows(data.v)
    random = np.random.default_rng(1)
    q = robot.tree.configuration(robot.home, pin.SE3.Random())
    pin.forwardKinematics(model, data, q, random.normal(size=model.nv))
    assert len(placements) == len(twists) == model.njoints
    for row, place, twist, motion in zip(placements, data.oMi, twists, data.v, strict=True):
        assert np.array_equal(
            row.reshape(4, 3).T, np.column_stack([place.rotation, place.translation])
        )
        assert np.array_equal(twist, motion.vector)


def test_external_forces_add_up_until_cleared(robot):
    forces = ExternalForces(robot.tree.model)
    wrench = np.arange(6.0)
    forces.add(3, wrench)
    forces.add(3, wrench)
    forces.add(robot.tree.model.njoints - 1, wrench)
    totals = [2 * wrench if joint == 3 else 0 * wrench for joint in range(len(forces.list) - 1)]
    for force, total in zip(forces.list, [*totals, wrench], strict=True):
        assert np.array_equal(force.vector, total)
    forces.clear()
    assert not any(force.vector.any() for force in forces.list)


@pytest.mark.parametrize("fixed", [False, True])
def test_the_acceleration_solves_the_equation_of_motion(robot, fixed):
    body, tree = Body(robot, 1e-3), robot.tree
    random = np.random.default_rng(2)
    body.place(tree.configuration(random.uniform(-0.5, 0.5, robot.n)), fixed)
    body.v[6:] = random.normal(size=robot.n)
    torque, damping = random.normal(size=robot.n), random.uniform(0.0, 9.0, robot.n)
    body.accelerate(torque, 2 * damping)
    body.accelerate(torque, damping)
    data, free = tree.model.createData(), slice(6 if fixed else 0, None)
    mass = np.array(pin.crba(tree.model, data, body.q))
    mass = np.triu(mass) + np.triu(mass, 1).T
    mass[np.ix_(tree.joint_v, tree.joint_v)] += robot.rotor_inertia + np.diag(1e-3 * damping)
    drive = tree.velocity(torque) - pin.nonLinearEffects(tree.model, data, body.q, body.v)
    expected = np.zeros(tree.model.nv)
    expected[free] = np.linalg.solve(mass[free, free], drive[free])
    assert body.a == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_rotors_that_couple_two_branches_are_an_error_that_names_the_joints(robot):
    inertia = robot.rotor_inertia.copy()
    left, right = (robot.joints.index(name) for name in ("l_knee", "r_knee"))
    inertia[left, right] = inertia[right, left] = 0.01
    with pytest.raises(ValueError, match="icub: rotor_blocks: .* got r_knee and l_knee of diff"):
        Body(replace(robot, rotor_inertia=inertia), 1e-3)
