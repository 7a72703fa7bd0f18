"""The torque observer against an independent plant: MuJoCo's motion, sensors and contacts."""

from typing import NamedTuple

import numpy as np
import pytest

from estimation.torque_observer import TorqueObserver
from experiments.mujoco_plant import MujocoPlant

SECONDS, EVERY = 1.2, 5
RELATIVE = 1e-9  # with MuJoCo's solver at its own tolerance of 1e-8 the floor leaves 5e-5


class TimedPush(NamedTuple):
    """A force that rises and falls like half a sine; link axes."""

    link: str
    point: tuple[float, float, float]  # m
    force: tuple[float, float, float]  # N
    start: float  # s
    duration: float  # s


PUSHES = {
    "floor": [
        TimedPush("chest", (0.0, 0.05, -0.08), (3.0, -8.0, 12.0), 0.2, 0.8),
        TimedPush("l_forearm", (0.02, 0.03, -0.01), (4.0, 6.0, -8.0), 0.1, 0.6),
        TimedPush("r_upper_leg", (0.06, -0.02, -0.05), (-12.0, 4.0, 0.0), 0.4, 0.7),
    ],
    "pole": [
        TimedPush("r_hand", (0.0, -0.01, 0.01), (5.0, -3.0, 9.0), 0.1, 0.9),
        TimedPush("l_upper_arm", (-0.02, -0.04, 0.03), (0.0, 20.0, 5.0), 0.2, 0.5),
        TimedPush("r_lower_leg", (0.05, 0.0, -0.09), (-30.0, 5.0, 10.0), 0.3, 0.8),
        TimedPush("l_foot", (0.03, 0.0, 0.0), (10.0, 10.0, -25.0), 0.5, 0.6),
    ],
}


def goal(robot, support: str, time: float) -> np.ndarray:
    """Arms, neck and torso swing; on the pole the legs too."""
    moving = np.ones(robot.n)
    if support == "floor":
        moving[np.concatenate([robot.parts["left_leg"], robot.parts["right_leg"]])] = 0.0
    phase = np.arange(robot.n)
    size = 0.3 if support == "pole" else 0.1
    return robot.home + size * moving * (np.sin(5.0 * time + phase) - np.sin(phase))


def relative(estimated, true) -> float:
    return float(np.abs(estimated - true).max() / max(1.0, np.abs(true).max()))


@pytest.mark.parametrize("support", ["floor", "pole"])
def test_torques_and_wrenches_are_those_of_mujoco_in_a_motion_with_pushes(robot, support):
    plant = MujocoPlant(robot, "free" if support == "floor" else "fixed")
    plant.model.opt.tolerance = 1e-13  # the floor's forces must balance what they accelerate
    observer = TorqueObserver(robot, support)
    observer.set_contacts([(push.link, np.array(push.point)) for push in PUSHES[support]])
    torque_errors, wrench_errors, most = [], [], np.zeros(len(observer.contacts))
    for tick in range(1, round(SECONDS * 1e3)):
        move(plant, support, tick * 1e-3)
        if tick % EVERY:
            continue
        exact = plant.readings
        inertial = exact.gyro[0], exact.acceleration[0], exact.angular_acceleration[0]
        estimate = observer.step(exact.q, exact.dq, exact.ddq, exact.ft, *inertial)
        true = wrenches(observer, plant)
        torque_errors.append(relative(estimate.torque, exact.link_torque))
        wrench_errors.append(relative(estimate.wrench, true))
        most = np.maximum(most, np.abs(true[:, :3]).max(axis=1))
    assert max(torque_errors) < RELATIVE
    assert max(wrench_errors) < RELATIVE
    pushed = [robot.subtree_of(push.link) for push in PUSHES[support]]
    assert (most[pushed] > 5.0).all()  # N: the pushes were there
    assert not plant.fallen


def move(plant: MujocoPlant, support: str, time: float) -> None:
    """Advance by a tick; a push begins when it is time."""
    plant.boards.command("position", goal(plant.robot, support, time))
    for push in PUSHES[support]:
        if round(push.start * 1e3) == round(time * 1e3):
            what = np.array(push.point), np.array(push.force)
            plant.push(push.link, *what, profile="half_sine", duration=push.duration)
    plant.step()


def wrenches(observer: TorqueObserver, plant: MujocoPlant) -> np.ndarray:
    """True wrenches in the rows and frames of the observer's contacts."""
    forces = {link: np.pad(force, (0, 3)) for link, force in plant.pushed().items()}
    known = forces | plant.support_wrenches()
    return np.array([known.get(contact.frame, np.zeros(6)) for contact in observer.contacts])
