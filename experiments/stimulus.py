"""Known wrenches at a frame, one component after the other, from pushes on its link."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from robot_model import Robot
from robot_model.messages import GroundTruth
from robot_sim import Plant

Array = np.ndarray
PERIOD, LENGTH = 2.0, 1.5  # s from one stimulus to the next, and how long each acts
FORCE = 10.0  # N
LEVER = 0.05  # m, between the two forces of a couple


class PointForce(NamedTuple):
    """A force [N] at a point [m], both in the frame's axes."""

    point: Array  # (3,)
    force: Array  # (3,)


Stimulus = Sequence[PointForce]  # at once


def stimuli() -> list[Stimulus]:
    """Three forces, three couples, and a force beside the frame's origin."""
    axes, origin = np.eye(3), np.zeros(3)
    forces: list[Stimulus] = [[PointForce(origin, FORCE * axis)] for axis in axes]
    couples: list[Stimulus] = [
        [
            PointForce(0.5 * LEVER * axes[(i + 1) % 3], FORCE * axes[(i + 2) % 3]),
            PointForce(-0.5 * LEVER * axes[(i + 1) % 3], -FORCE * axes[(i + 2) % 3]),
        ]
        for i in range(3)
    ]
    beside = PointForce(np.array([0.02, -0.03, 0.04]), np.full(3, -0.5 * FORCE))
    return [*forces, *couples, [beside]]


class Stimulated:
    """A frame of a robot on which known wrenches act, and what they are."""

    def __init__(self, robot: Robot, frame: str):
        self._tree = robot.tree
        self._data = self._tree.model.createData()
        self._frame = self._tree.frame_id(frame)
        self._link, self._link_m_frame = robot.frame(frame)

    def push(self, plant: Plant, stimulus: Stimulus) -> None:
        """Let a stimulus rise and fall like half a sine from the next step on."""
        place = self._link_m_frame
        for point, force in stimulus:
            turned = place.rotation @ force
            plant.push(self._link, place.act(point), turned, profile="half_sine", duration=LENGTH)

    def truth(self, truth: GroundTruth) -> tuple[Array, Array]:
        """Return the wrench (6,) about the frame in its axes, and J' w (n,), eq. (4.3.1)."""
        model, data = self._tree.model, self._data
        w, x, y, z = truth.base_quat_wxyz
        base = np.array([*truth.base_position, x, y, z, w])
        pin.computeJointJacobians(model, data, self._tree.configuration(truth.q, base))
        world_m_frame = pin.updateFramePlacement(model, data, self._frame)
        jacobian = pin.getFrameJacobian(model, data, self._frame, pin.ReferenceFrame.LOCAL)
        wrench = self._wrench(truth, world_m_frame)
        return wrench, jacobian[:, self._tree.joint_v].T @ wrench

    def _wrench(self, truth: GroundTruth, world_m_frame: pin.SE3) -> Array:
        wrench = np.zeros(6)
        for push in truth.pushes:
            force = world_m_frame.rotation.T @ push["force_world"]
            point = self._link_m_frame.actInv(np.array(push["point"]))
            wrench += np.concatenate([force, np.cross(point, force)])
        return wrench
