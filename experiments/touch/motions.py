"""What the robot does while it is pushed or left alone: seeded, slow sinusoids."""

from typing import NamedTuple

import numpy as np

from robot_model import Robot
from robot_sim.motions import Motion, Sinusoid


class Kind(NamedTuple):
    """Amplitudes [rad] by part, and the frequencies [Hz] between which each joint's is drawn."""

    base: str  # free or fixed
    amplitudes: dict[str, float]
    frequency: tuple[float, float] = (0.15, 0.6)


ARMS = ("left_arm", "right_arm")
LEGS = ("left_leg", "right_leg")
KINDS = {
    "still": Kind("free", {}),
    "sway": Kind("free", dict.fromkeys(LEGS, 0.02) | dict.fromkeys(ARMS, 0.05) | {"torso": 0.06}),
    "upper body": Kind("free", dict.fromkeys((*ARMS, "head"), 0.25) | {"torso": 0.08}),
    "pole": Kind("fixed", dict.fromkeys((*ARMS, *LEGS, "torso", "head"), 0.2)),
    "load shift": Kind("free", {"rolls": 0.04}, (0.15, 0.4)),
    "fast arms": Kind("free", dict.fromkeys(ARMS, 0.25), (0.7, 1.2)),
    "every joint": Kind(
        "free", dict.fromkeys(LEGS, 0.02) | dict.fromkeys((*ARMS, "head"), 0.25) | {"torso": 0.08}
    ),
}
CONTACT_FREE = ("still", "sway", "upper body", "pole", "load shift", "fast arms")
PUSHED = ("still", "sway", "upper body", "pole")
STANDING = ("still", "sway", "upper body")


def drawn_motion(robot: Robot, kind: str, random: np.random.Generator) -> Motion | None:
    """Draw a motion of a kind; None when the robot keeps still."""
    joints = {}
    for part, amplitude in KINDS[kind].amplitudes.items():
        joints |= (
            _rolls(robot, amplitude, kind, random)
            if part == "rolls"
            else {robot.joints[i]: _sinusoid(amplitude, kind, random) for i in robot.parts[part]}
        )
    return Motion(kind, joints) if joints else None


def _sinusoid(amplitude: float, kind: str, random: np.random.Generator) -> Sinusoid:
    frequency = random.uniform(*KINDS[kind].frequency)
    return Sinusoid(
        amplitude=amplitude * random.uniform(0.5, 1.0),
        frequency=frequency,
        phase=random.uniform(0.0, 2.0 * np.pi),
    )


def _rolls(
    robot: Robot, amplitude: float, kind: str, random: np.random.Generator
) -> dict[str, Sinusoid]:
    """Hips and ankles roll together, so that the weight goes from foot to foot."""
    one = _sinusoid(amplitude, kind, random)
    other = one.model_copy(update={"phase": one.phase + np.pi})
    names = {"l_hip_roll": one, "r_hip_roll": other, "l_ankle_roll": other, "r_ankle_roll": one}
    return {name: sinusoid for name, sinusoid in names.items() if name in robot.joints}
