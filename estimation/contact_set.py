"""Where unknown external wrenches act: one contact per sub-tree."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from robot_model import Robot


@dataclass(frozen=True, eq=False)
class Contact:
    """A place at which the world may exert a wrench on a sub-tree.

    The wrench is expressed in the axes of ``frame`` about ``point``. ``kind`` is
    "support" (known contact, never a touch), "default" (assumed when nothing is
    known) or "touch" (given).
    """

    frame: str
    link: str
    subtree: int
    point: np.ndarray  # (3,) m, in the frame of ``link``
    kind: str
    placement: pin.SE3  # link_M_contact


Touch = tuple[str, np.ndarray]  # URDF link or frame, point (3,) m in it


def contact_set(robot: Robot, support: str, touches: Iterable[Touch] = ()) -> tuple[Contact, ...]:
    """Return the contact of each sub-tree, in the order of ``robot.subtrees``.

    Args:
        robot: The robot.
        support: Kind of support, a key of ``robot.supports``.
        touches: Points where the robot is touched. Each replaces the default contact
            of its sub-tree.

    Raises:
        LookupError: Unknown link or support.
        ValueError: Two points on one sub-tree, a point on a supporting sub-tree (its
            wrench cannot be told from the support's), or a non-finite point.
    """
    supports = support_by_subtree(robot, support)
    given: dict[int, Contact] = {}
    for link, point in touches:
        contact = _touch(robot, link, np.asarray(point, dtype=float))
        _check_free(robot, contact, supports, given)
        given[contact.subtree] = contact
    return tuple(
        given.get(i) or _at_frame(robot, i, supports.get(i)) for i in range(len(robot.subtrees))
    )


def support_by_subtree(robot: Robot, support: str) -> dict[int, str]:
    """Return the support frame of each sub-tree that has one.

    Raises:
        LookupError: The robot has no such support.
    """
    if support not in robot.supports:
        exist = ", ".join(robot.supports)
        raise LookupError(f"{robot.name} has no support '{support}'; there are: {exist}")
    return {robot.subtree_of(frame): frame for frame in robot.supports[support]}


def _at_frame(robot: Robot, subtree: int, support: str | None) -> Contact:
    frame = support or robot.subtrees[subtree].default_frame
    link, placement = robot.frame(frame)
    point = placement.translation.copy()
    kind = "support" if support else "default"
    return Contact(frame, link, subtree, point, kind, placement)


def _touch(robot: Robot, frame: str, point: np.ndarray) -> Contact:
    if point.shape != (3,) or not np.isfinite(point).all():
        raise ValueError(f"a contact point is three finite numbers [m], got {point} on '{frame}'")
    link, link_m_frame = robot.frame(frame)
    placement = link_m_frame * pin.SE3(np.eye(3), point)
    subtree = robot.subtree_of(link)
    return Contact(frame, link, subtree, placement.translation.copy(), "touch", placement)


def _check_free(
    robot: Robot, contact: Contact, supports: dict[int, str], given: dict[int, Contact]
) -> None:
    name = robot.subtrees[contact.subtree].name
    if contact.subtree in supports:
        raise ValueError(
            f"a touch on '{contact.frame}' cannot be told from the support at "
            f"'{supports[contact.subtree]}': both act on sub-tree {name}"
        )
    if contact.subtree in given:
        other = given[contact.subtree].frame
        raise ValueError(
            f"one unknown wrench per sub-tree: '{other}' and '{contact.frame}' both lie in {name}"
        )
