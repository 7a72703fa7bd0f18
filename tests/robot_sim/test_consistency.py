"""State, acceleration, forces and readings belong to one instant and obey mechanics."""

import numpy as np
import pinocchio as pin
import pytest

from robot_model import build_tree
from robot_sim import Plant
from robot_sim.contact import placement

SEEDS = range(20)


def world_wrench(frame, wrench):
    """Move a wrench from a frame (SE3, world_M_frame) to the world's origin and axes."""
    return frame.toDualActionMatrix() @ wrench


def whole_body(plant):
    """Return model and data of the uncut tree with all placements and rates up to date."""
    model = plant.robot.tree.model
    data = model.createData()
    body = plant._body
    pin.forwardKinematics(model, data, body.q, body.v, body.a)
    pin.updateFramePlacements(model, data)
    return model, data


@pytest.mark.parametrize("seed", SEEDS)
def test_inverse_dynamics_reproduces_the_commanded_torque(robot, thrown, seed):
    plant = Plant(robot, base="free")
    plant.push("l_forearm", np.array([0.02, 0.0, -0.05]), np.array([3.0, -8.0, 5.0]), "world")
    thrown(plant, seed)
    truth, body = plant.truth(), plant._body
    commanded = plant.boards.torque(truth.q, truth.dq)
    lag = body.tick * robot.viscous * truth.ddq  # friction acts at the end of the tick
    assert truth.motor_torque == pytest.approx(commanded - lag, abs=1e-9)
    residual = truth.motor_torque - robot.rotor_inertia @ truth.ddq - robot.viscous * truth.dq
    assert truth.link_torque == pytest.approx(residual, abs=1e-12)
    assert plant.readings.base_wrench == pytest.approx(np.zeros(6), abs=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_momentum_changes_by_the_external_forces(robot, thrown, seed):
    plant = Plant(robot)
    point, force = np.array([0.0, 0.03, 0.02]), np.array([20.0, 5.0, -7.0])
    plant.push("chest", point, force, "world")
    thrown(plant, seed)
    truth = plant.truth()
    model, data = whole_body(plant)
    body = plant._body
    pin.computeCentroidalMomentumTimeVariation(model, data, body.q, body.v, body.a)
    com = data.com[0]
    rate = data.dhg.vector.copy()
    pushed = data.oMf[robot.tree.frame_id("chest")].act(point)
    total = np.hstack([force, np.cross(pushed, force)])
    for name, wrench in zip(truth.support_frames, truth.support_wrench, strict=True):
        total += world_wrench(data.oMf[robot.tree.frame_id(name)], wrench)
    weight = np.array([0.0, 0.0, -robot.mass * 9.81])
    total += np.hstack([weight, np.cross(com, weight)])
    total[3:] -= np.cross(com, total[:3])
    assert rate == pytest.approx(total, abs=1e-8 * max(1.0, np.abs(total).max()))


@pytest.mark.parametrize("seed", SEEDS)
def test_force_torque_truth_equals_newton_and_euler_on_each_sub_tree(robot, thrown, seed):
    plant = Plant(robot)
    point, force = np.array([0.0, 0.02, -0.03]), np.array([4.0, -9.0, 6.0])
    plant.push("r_hand", point, force, "link")
    thrown(plant, seed)
    truth = plant.truth()
    model, data = whole_body(plant)

    def external(link_names):
        total = np.zeros(6)
        if "r_hand" in link_names:
            hand = data.oMf[robot.tree.frame_id("r_hand")]
            total += world_wrench(hand, np.hstack([force, np.cross(point, force)]))
        for name, wrench in zip(truth.support_frames, truth.support_wrench, strict=True):
            if robot.frame(name)[0] in link_names:
                total += world_wrench(data.oMf[robot.tree.frame_id(name)], wrench)
        return total

    def needed(link):
        """Wrench that link's motion and weight ask for, about the world's origin."""
        inertia = robot.urdf.links[link].inertia
        if inertia is None:
            return np.zeros(6)
        frame_id = robot.tree.frame_id(link)
        frame = data.oMf[frame_id]
        twist = pin.getFrameVelocity(model, data, frame_id, pin.LOCAL)
        rate = pin.getFrameAcceleration(model, data, frame_id, pin.LOCAL)
        rate.linear += frame.rotation.T @ [0.0, 0.0, 9.81]
        wrench = (inertia * rate).vector + twist.cross(inertia * twist).vector
        return world_wrench(frame, wrench)

    for i, sensor in enumerate(robot.ft_sensors):
        below = links_below(robot, robot.ft_elements[i].joint)
        expected = sum(needed(link) for link in below) - external(below)
        frame = data.oMf[robot.tree.frame_id(robot.ft_frames[i])]
        local = frame.inverse().toDualActionMatrix() @ expected
        scale = max(1.0, np.abs(local).max())
        assert truth.ft[i] == pytest.approx(local, abs=1e-9 * scale), sensor


def links_below(robot, joint):
    """All URDF links on the child side of a joint."""
    found = [robot.urdf.joints[joint].child]
    for link in found:
        found += [j.child for j in robot.urdf.joints.values() if j.parent == link]
    return set(found)


@pytest.mark.parametrize("sensor", range(6))
def test_a_push_enters_only_the_sensors_above_it(robot, thrown, sensor):
    element = robot.ft_elements[sensor]
    joint = robot.urdf.joints[element.joint]
    proximal = robot.frame(joint.parent)[0]
    distal = robot.frame(joint.child)[0]
    force = np.array([5.0, -3.0, 8.0])
    change = {}
    for link in (proximal, distal):
        plant = Plant(robot, base="fixed")
        before = plant.readings
        plant.push(link, np.zeros(3), force, "world")
        plant._evaluate()
        # Same state, other acceleration: what is left without the distal inertia's share.
        change[link] = plant.readings.ft[sensor] - before.ft[sensor]
        change[link] -= inertial_share(plant, sensor, before)
    rotation = world_rotation(plant, robot.ft_frames[sensor])
    assert change[proximal] == pytest.approx(np.zeros(6), abs=1e-9)
    assert change[distal][:3] == pytest.approx(-rotation.T @ force, abs=1e-9)


def world_rotation(plant, frame):
    tree, data = plant.robot.tree, plant._body.data
    place = placement(tree.model, tree.frame_id(frame))
    return data.oMi[place.joint].rotation @ place.joint_M_frame.rotation


def inertial_share(plant, sensor, before):
    """Part of the sensor's change that comes from the changed acceleration."""
    robot = plant.robot
    cut = build_tree(robot, robot.base_link, cut=True)
    data = cut.model.createData()
    q = cut.configuration(plant.q, plant._body.q[:7])
    change = cut.velocity(plant._body.a[robot.tree.joint_v] - before.ddq)
    mass = pin.crba(cut.model, data, q)
    return (mass @ change)[cut.cut_v[sensor]]


def test_the_imu_at_rest_reads_gravity_upwards(robot):
    plant = Plant(robot, base="fixed")
    for _ in range(8000):
        plant.step()
    raw = plant.raw()
    assert raw.imu_quat_wxyz is not None
    w, x, y, z = raw.imu_quat_wxyz[0]
    upwards = pin.Quaternion(w, x, y, z).toRotationMatrix() @ raw.imu_acc[0]
    assert upwards == pytest.approx([0.0, 0.0, 9.81], abs=1e-3)
    assert raw.imu_gyro[0] == pytest.approx(np.zeros(3), abs=1e-3)


def test_imu_and_velocities_equal_finite_differences_of_the_poses(robot):
    plant = Plant(robot)
    plant.push("chest", np.zeros(3), np.array([30.0, 20.0, 0.0]), "world", "hold", 0.3)
    poses, frames = [], []
    for _ in range(160):
        plant.step()
        raw = plant.raw()
        place = placement(robot.tree.model, robot.tree.frame_id(robot.imus[0]))
        poses.append(plant._body.data.oMi[place.joint] * place.joint_M_frame)
        assert raw.imu_dgyro is not None
        frames.append((raw.imu_gyro[0], raw.imu_acc[0], raw.imu_dgyro[0]))
    before, now, after = poses[-3:]
    gyro, acc, dgyro = frames[-2]
    h = 1e-3
    turn = pin.log3(before.rotation.T @ after.rotation) / (2 * h)
    second = (after.translation - 2 * now.translation + before.translation) / h**2
    assert gyro == pytest.approx(turn, abs=2e-2)
    proper = now.rotation.T @ (second + [0.0, 0.0, 9.81])
    # Semi-implicit Euler: the second difference is the acceleration of the middle tick.
    assert acc == pytest.approx(proper, abs=2e-2)
    slope = (frames[-1][0] - frames[-3][0]) / (2 * h)
    assert dgyro == pytest.approx(slope, abs=0.5 + 0.1 * np.abs(dgyro).max())
