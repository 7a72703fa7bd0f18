"""Where unknown external wrenches act: at least one contact per sub-tree, unless told otherwise."""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from estimation.contact_wrenches import (
    ContactUnknown,
    force_along,
    full_wrench,
    known_wrench,
    pure_force,
)
from robot_model import Robot

MOST = 64  # touches at a time
NONE = "none"

_Unknown = Callable[[pin.SE3, np.ndarray], ContactUnknown]
UNKNOWNS: Mapping[str, tuple[int, _Unknown]] = {  # numbers that must be given, and what it makes
    "wrench": (0, lambda placement, _: full_wrench(placement)),
    "force": (0, lambda placement, _: pure_force(placement)),
    "direction": (3, force_along),
    "known": (6, known_wrench),
}


class Touch(NamedTuple):
    """Somewhere the world touches the robot, and what is known of the wrench there.

    ``unknown`` is "wrench", "force" (no moment about the point), "direction" (a force along
    ``vector`` (3,), of any length), "known" (the wrench ``vector`` (6,), N and N m) or "none"
    (nothing touches the sub-tree in which the frame lies). Vectors are in the frame's axes.
    """

    frame: str  # URDF link or frame
    point: np.ndarray  # (3,) m, in it
    unknown: str = "wrench"
    vector: np.ndarray | None = None


AnyTouch = Touch | tuple[str, np.ndarray]


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
    push: ContactUnknown  # what of its wrench is unknown

    @property
    def full(self) -> bool:
        """Whether nothing is known of its wrench."""
        return self.push.free.shape[1] == 6


def contact_set(
    robot: Robot, support: str, touches: Iterable[AnyTouch] = ()
) -> tuple[Contact, ...]:
    """Return the contacts of each sub-tree, in the order of ``robot.subtrees``.

    Args:
        robot: The robot.
        support: Kind of support, a key of ``robot.supports``.
        touches: Where the robot is touched. They take the place of the default contact of
            their sub-trees; on a supporting one they come beside the support.

    Raises:
        LookupError: Unknown link, support or kind of touch.
        ValueError: A point or a vector that is none, "none" where something touches, or
            too many touches.
    """
    supports = support_by_subtree(robot, support)
    given = _by_subtree(robot, [t if isinstance(t, Touch) else Touch(*t) for t in touches])
    return tuple(
        contact
        for i in range(len(robot.subtrees))
        for contact in _on_subtree(robot, i, supports.get(i, ()), given.get(i))
    )


def net_contacts(robot: Robot, contacts: Sequence[Contact]) -> tuple[Contact, ...]:
    """Return where the net wrench of each sub-tree is told: at its first contact, if any."""
    first = {contact.subtree: contact for contact in reversed(contacts)}
    return tuple(
        first.get(i) or _at_frame(robot, subtree.default_frame, "default")
        for i, subtree in enumerate(robot.subtrees)
    )


def shared_subtrees(robot: Robot, contacts: Sequence[Contact]) -> dict[int, tuple[Contact, ...]]:
    """Return the contacts of each sub-tree that has not just one full wrench."""
    on = {i: tuple(c for c in contacts if c.subtree == i) for i in range(len(robot.subtrees))}
    return {i: some for i, some in on.items() if len(some) != 1 or not some[0].full}


def numbered(names: Iterable[str]) -> list[str]:
    """Return names that differ: the second of a name gets ``_2``."""
    seen: Counter[str] = Counter()
    result = []
    for name in names:
        seen[name] += 1
        result.append(f"{name}_{seen[name]}" if seen[name] > 1 else name)
    return result


def support_by_subtree(robot: Robot, support: str) -> dict[int, tuple[str, ...]]:
    """Return the support frames of each sub-tree that has any.

    Raises:
        LookupError: The robot has no such support.
    """
    if support not in robot.supports:
        exist = ", ".join(robot.supports)
        raise LookupError(f"{robot.name} has no support '{support}'; there are: {exist}")
    frames: dict[int, tuple[str, ...]] = defaultdict(tuple)
    for frame in robot.supports[support]:
        frames[robot.subtree_of(frame)] += (frame,)
    return dict(frames)


def _on_subtree(
    robot: Robot, subtree: int, supports: Sequence[str], touches: list[Touch] | None
) -> list[Contact]:
    if touches is None and not supports:
        return [_at_frame(robot, robot.subtrees[subtree].default_frame, "default")]
    bearing = [_at_frame(robot, frame, "support") for frame in supports]
    pushed = [touch for touch in touches or () if touch.unknown != NONE]
    if len(pushed) < len(touches or ()) and (bearing or pushed):
        other = (bearing or [_touched(robot, touch) for touch in pushed])[0]
        name = robot.subtrees[subtree].name
        raise ValueError(f"'none' for sub-tree {name}, but it is touched at '{other.frame}'")
    return bearing + [_touched(robot, touch) for touch in pushed]


def _at_frame(robot: Robot, frame: str, kind: str) -> Contact:
    link, placement = robot.frame(frame)
    point = placement.translation.copy()
    push = full_wrench(pin.SE3.Identity())
    return Contact(frame, link, robot.subtree_of(frame), point, kind, placement, push)


def _by_subtree(robot: Robot, touches: list[Touch]) -> dict[int, list[Touch]]:
    if len(touches) > MOST:
        raise ValueError(f"{len(touches)} contact points, at most {MOST} are possible at a time")
    given = defaultdict(list)
    for touch in touches:
        given[robot.subtree_of(robot.frame(touch.frame)[0])].append(touch)
    return given


def _touched(robot: Robot, touch: Touch) -> Contact:
    point = np.asarray(touch.point, dtype=float)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise ValueError(
            f"a contact point is three finite numbers [m], got {point} on '{touch.frame}'"
        )
    link, link_m_frame = robot.frame(touch.frame)
    placement = link_m_frame * pin.SE3(np.eye(3), point)
    subtree, place = robot.subtree_of(link), placement.translation.copy()
    return Contact(touch.frame, link, subtree, place, "touch", placement, _push(touch))


def _push(touch: Touch) -> ContactUnknown:
    if touch.unknown not in UNKNOWNS:
        exist = ", ".join([*UNKNOWNS, NONE])
        raise LookupError(
            f"unknown '{touch.unknown}' of the contact on '{touch.frame}'; there are: {exist}"
        )
    size, make = UNKNOWNS[touch.unknown]
    vector = np.zeros(size) if touch.vector is None else np.asarray(touch.vector, dtype=float)
    if size and vector.shape != (size,):
        raise ValueError(
            f"'{touch.unknown}' of the contact on '{touch.frame}': expected {size} numbers,"
            f" got {vector.size}"
        )
    return make(pin.SE3.Identity(), vector)
