"""iCub leaning over its left foot, the right one in the air: it stands with stiff boards."""

from dataclasses import replace

import numpy as np

from robot_model import Robot

FOOT = "l_sole"
STIFFER = 20.0  # than the boards' gains, which let it topple
POSTURE = {  # rad; the centre of mass is above the middle of the foot
    "l_hip_roll": 0.029,
    "l_ankle_roll": 0.15,
    "l_ankle_pitch": -0.373,
    "r_hip_pitch": 0.5,
    "r_knee": -1.0,
    "r_ankle_pitch": -0.5,
}


def on_one_foot(robot: Robot) -> Robot:
    """Return iCub as a plant that starts, and stays, on its left foot alone."""
    home = robot.home.copy()
    home[[robot.joints.index(name) for name in POSTURE]] = list(POSTURE.values())
    return replace(
        robot,
        home=home,
        supports={"floor": (FOOT,)},
        soles={FOOT: robot.soles[FOOT]},
        board_kp=STIFFER * robot.board_kp,
        board_kd=np.sqrt(STIFFER) * robot.board_kd,
    )
