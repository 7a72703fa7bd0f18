"""Where the base is when the robot stands at its home posture."""

import numpy as np
import pinocchio as pin

from robot_model import Robot
from robot_sim.contact import Floor, stands_on

GRAVITY = 9.81  # m/s^2


def standing_base(robot: Robot, floor: Floor) -> pin.SE3:
    """Return the pose of the base link, with the soles level under the robot.

    The first sole's axes become the world's, the middle of the sole frames is the
    origin, and the soles sink into the floor until the springs carry the weight. A
    robot without soles has its base at the origin.
    """
    tree, frames = robot.tree, stands_on(robot)
    if not frames:
        return pin.SE3.Identity()
    data = tree.model.createData()
    pin.framesForwardKinematics(tree.model, data, tree.configuration(robot.home))
    soles = [data.oMf[tree.frame_id(frame)] for frame in frames]
    corners = np.array(
        [s.act(c) for s, f in zip(soles, frames, strict=True) for c in robot.soles[f]]
    )
    level = soles[0].rotation.T
    middle = level @ np.mean([sole.translation for sole in soles], axis=0)
    lowest = (corners @ level.T)[:, 2].min()
    sinking = pin.computeTotalMass(tree.model) * GRAVITY / (len(corners) * floor.stiffness)
    return pin.SE3(level, np.array([-middle[0], -middle[1], -lowest - sinking]))
