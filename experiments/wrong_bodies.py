"""A robot as its observer takes it for: masses and centres of mass are wrong."""

from dataclasses import replace

import numpy as np
import pinocchio as pin

from robot_model import Robot


def wrong_bodies(robot: Robot, random: np.random.Generator, mass: float, center: float) -> Robot:
    """Return the robot with normal errors of each body.

    Args:
        robot: The robot as it is.
        random: Draws the errors.
        mass: Standard deviation of a mass, as a share of it; the inertia goes with it.
        center: Standard deviation of each coordinate of a centre of mass [m].
    """
    bodies = {
        name: replace(body, inertia=_wrong(body.inertia, random, mass, center))
        for name, body in robot.bodies.items()
    }
    return replace(robot, bodies=bodies)


def _wrong(
    inertia: pin.Inertia, random: np.random.Generator, mass: float, center: float
) -> pin.Inertia:
    factor, moved = 1.0 + mass * random.normal(), center * random.normal(size=3)
    if inertia.mass == 0.0:
        return inertia
    return pin.Inertia(factor * inertia.mass, inertia.lever + moved, factor * inertia.inertia)
