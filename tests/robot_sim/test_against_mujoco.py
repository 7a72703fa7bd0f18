"""The plant's accelerations and F/T truth against an independent engine."""

import numpy as np

from experiments.mujoco_robot import add_force, bare_spec, mujoco
from robot_model import Robot
from robot_sim import Plant
from robot_sim.contact import placement

STATES = 200


class MujocoTwin:
    """The robot's URDF in MuJoCo, without floor, damping, limits or rotors."""

    def __init__(self, robot: Robot):
        self.robot = robot
        spec = bare_spec(robot)
        spec.body(robot.base_link).add_freejoint(name="base")
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        joints = [self.model.joint(name) for name in robot.joints]
        self.joint_q = np.array([joint.qposadr[0] for joint in joints])
        self.joint_v = np.array([joint.dofadr[0] for joint in joints])

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
            add_force(self.data, push["link"], point, np.array(push["force_world"]))
        for frame, wrench in zip(truth.support_frames, truth.support_wrench, strict=True):
            tree = plant.robot.tree
            place = placement(tree.model, tree.frame_id(frame))
            sole = plant._body.data.oMi[place.joint] * place.joint_M_frame
            force, moment = sole.rotation @ wrench[:3], sole.rotation @ wrench[3:]
            add_force(self.data, self.robot.frame(frame)[0], sole.translation, force, moment)


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
