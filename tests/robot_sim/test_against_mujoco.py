"""The plant's accelerations and F/T truth against an independent engine."""

import xml.etree.ElementTree as ElementTree

import numpy as np
import pinocchio as pin
import pytest

from robot_model import Robot
from robot_sim import Plant
from robot_sim.contact import placement

mujoco = pytest.importorskip("mujoco")

STATES = 200


class MujocoTwin:
    """The robot's URDF in MuJoCo, without floor, damping, limits or rotors."""

    def __init__(self, robot: Robot):
        self.robot = robot
        spec = mujoco.MjSpec.from_string(bare_urdf(robot))
        spec.body(robot.base_link).add_freejoint(name="base")
        for i, element in enumerate(robot.ft_elements):
            self._add_sensor(spec, i, element.joint)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        joints = [self.model.joint(name) for name in robot.joints]
        self.joint_q = np.array([joint.qposadr[0] for joint in joints])
        self.joint_v = np.array([joint.dofadr[0] for joint in joints])

    def _add_sensor(self, spec, index, joint):
        """A site in the reading's frame, on the child: MuJoCo reads parent on child there."""
        urdf_joint = self.robot.urdf.joints[joint]
        place = urdf_joint.origin.inverse() * self.robot.ft_placements[index]
        x, y, z, w = pin.Quaternion(place.rotation).coeffs()
        name = self.robot.ft_sensors[index]
        site = dict(name=name, pos=place.translation, quat=[w, x, y, z])
        spec.body(urdf_joint.child).add_site(**site)
        for kind in (mujoco.mjtSensor.mjSENS_FORCE, mujoco.mjtSensor.mjSENS_TORQUE):
            spec.add_sensor(
                name=f"{name}_{kind}", type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=name
            )

    def evaluate(self, plant: Plant):
        """Return ddq (n,), classical base acceleration (6,) and F/T (k, 6) of its state."""
        truth, data = plant.truth(), self.data
        rotation = plant._body.data.oMi[1].rotation
        data.qpos[:3], data.qpos[3:7] = truth.base_position, truth.base_quat_wxyz
        data.qvel[:3], data.qvel[3:6] = rotation @ truth.base_twist[:3], truth.base_twist[3:]
        data.qpos[self.joint_q], data.qvel[self.joint_v] = truth.q, truth.dq
        data.qfrc_applied[:] = 0.0
        data.qfrc_applied[self.joint_v] = truth.link_torque
        data.xfrc_applied[:] = 0.0
        mujoco.mj_kinematics(self.model, data)
        mujoco.mj_comPos(self.model, data)
        self._apply(plant, truth)
        mujoco.mj_forward(self.model, data)
        ft = data.sensordata.reshape(-1, 6).copy()
        return data.qacc[self.joint_v], data.qacc[:6].copy(), ft

    def _apply(self, plant, truth):
        for push in truth.pushes:
            body = self.data.body(push["link"])
            point = body.xpos + body.xmat.reshape(3, 3) @ push["point"]
            self._add_force(push["link"], point, np.array(push["force_world"]), np.zeros(3))
        for frame, wrench in zip(truth.support_frames, truth.support_wrench, strict=True):
            tree = plant.robot.tree
            place = placement(tree.model, tree.frame_id(frame))
            sole = plant._body.data.oMi[place.joint] * place.joint_M_frame
            force, moment = sole.rotation @ wrench[:3], sole.rotation @ wrench[3:]
            self._add_force(self.robot.frame(frame)[0], sole.translation, force, moment)

    def _add_force(self, link, point, force, moment):
        body = self.data.body(link)
        self.data.xfrc_applied[body.id, :3] += force
        self.data.xfrc_applied[body.id, 3:] += moment + np.cross(point - body.xipos, force)


def bare_urdf(robot: Robot) -> str:
    """The robot's URDF without shapes, damping and vendor tags; fixed links stay bodies."""
    root = ElementTree.parse(robot.urdf.path).getroot()
    for link in root.findall("link"):
        for tag in ("visual", "collision"):
            for element in link.findall(tag):
                link.remove(element)
    for joint in root.findall("joint"):
        for tag in ("dynamics", "limit"):
            for element in joint.findall(tag):
                joint.remove(element)
        if joint.get("type") == "revolute":
            joint.set("type", "continuous")
    for tag in ("gazebo", "sensor", "transmission"):
        for element in root.findall(tag):
            root.remove(element)
    options = ElementTree.SubElement(root, "mujoco")
    ElementTree.SubElement(options, "compiler", fusestatic="false", discardvisual="false")
    return ElementTree.tostring(root, encoding="unicode")


def test_accelerations_and_force_torque_equal_mujocos_on_random_states(robot, thrown):
    twin = MujocoTwin(robot)
    plant = Plant(robot)
    worst_acceleration = worst_force = 0.0
    for seed in range(STATES):
        plant.reset()
        link = robot.links[seed % len(robot.links)]
        plant.push(link, np.array([0.02, -0.03, 0.05]), np.array([7.0, -11.0, 4.0]), "world")
        thrown(plant, seed)
        truth = plant.truth()
        ddq, base, ft = twin.evaluate(plant)
        rotation = plant._body.data.oMi[1].rotation
        linear, angular = truth.base_twist[:3], truth.base_twist[3:]
        classical = rotation @ (truth.base_acceleration[:3] + np.cross(angular, linear))
        ours = np.hstack([truth.ddq, classical, truth.base_acceleration[3:]])
        error = np.abs(np.hstack([ddq, base]) - ours).max() / np.abs(ours).max()
        worst_acceleration = max(worst_acceleration, error)
        worst_force = max(worst_force, np.abs(ft - truth.ft).max() / np.abs(truth.ft).max())
    assert worst_acceleration < 1e-9
    assert worst_force < 1e-9
