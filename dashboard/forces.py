"""Forces that act on the robot, in the world: what the page draws as arrows."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from robot_model.messages import ExternalWrenches, GroundTruth

from .placement import Placement

Array = np.ndarray


class Force(NamedTuple):
    """A force that the world exerts on the robot at a point."""

    point: Array  # (3,) [m], world
    force: Array  # (3,) [N], world
    support: bool
    decided: bool = True  # by the data, that is


def estimated_forces(wrenches: ExternalWrenches, placement: Placement) -> list[Force]:
    """Return the valid external wrenches as forces at their contact points."""
    return [
        Force(
            placement.point(wrenches.link[i], wrenches.point[i]),
            placement.vector(wrenches.frame[i], wrenches.wrench[i, :3]),
            wrenches.kind[i] == "support",
            not wrenches.decided or wrenches.decided[i],
        )
        for i in np.flatnonzero(wrenches.valid)
    ]


def true_forces(truth: GroundTruth, placement: Placement) -> list[Force]:
    """Return the plant's pushes and support forces; the placement is that of truth."""
    pushes = [
        Force(
            placement.point(push["link"], np.asarray(push["point"], dtype=float)),
            np.asarray(push["force_world"], dtype=float),
            False,
        )
        for push in truth.pushes
    ]
    supports = [
        Force(placement.point(frame, np.zeros(3)), placement.vector(frame, wrench[:3]), True)
        for frame, wrench in zip(truth.support_frames, truth.support_wrench, strict=True)
    ]
    return pushes + supports


def segments(forces: Iterable[Force], scale: float, hide_below: float) -> Array:
    """Return arrows (m, 2, 3) [m] whose tips are the points where the forces act.

    ``scale`` is in m/N; forces smaller than ``hide_below`` [N] are left out.
    """
    drawn = [
        (force.point - scale * force.force, force.point)
        for force in forces
        if np.linalg.norm(force.force) >= hide_below
    ]
    return np.array(drawn, dtype=np.float32).reshape(-1, 2, 3)
