"""Any wrench of one sample, in any frame, orientation and point."""

from collections.abc import Callable

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from estimation.contact_set import numbered
from estimation.torque_observer import TorqueObserver
from robot_model.names import did_you_mean

Array = np.ndarray


class WrenchQuery:
    """Answers what acts on what, in one sample of an observer.

    ``contact:<frame>`` is what the world exerts there (``contact:<frame>_2`` for the second
    on a frame), ``subtree:<name>`` its net effect on a sub-tree, ``sensor:<name>`` a reading
    without its offset, ``joint:<name>`` what the joint's parent exerts on its child
    (Fumagalli, eqs. (3.4.6) and (3.4.7)), and ``link:<name>`` the sum of all wrenches on a
    link: those of joints, sensors and world, which move it and hold it against gravity,
    eqs. (3.4.4) and (3.4.5).

    Args:
        observer: Computes the sample anew.
        sample: Arguments of its step.
    """

    def __init__(self, observer: TorqueObserver, *sample: Array):
        self.estimate = observer.step(*sample)
        self._observer, self._graph, self._robot = observer, observer.graph, observer.robot
        self._kinds: dict[str, tuple[Callable[[str], tuple[Array, str]], list[str]]] = {
            "contact": (self._contact, numbered([c.frame for c in observer.contacts])),
            "subtree": (self._subtree, [subtree.name for subtree in self._robot.subtrees]),
            "sensor": (self._sensor, list(self._robot.ft_sensors)),
            "joint": (self._joint, list(self._robot.joints)),
            "link": (self._link, list(self._robot.urdf.links)),
        }

    def wrench(
        self, of: str, frame: str = "", axes: str = "", point: ArrayLike | None = None
    ) -> tuple[Array, str]:
        """Return a wrench (6,) [f m], N and N m, and the frame in which it is told.

        Args:
            of: ``kind:name``.
            frame: URDF link or frame about whose origin it is told; its own when empty.
            axes: URDF link or frame in whose axes it is told; ``frame`` when empty.
            point: (3,) m in ``frame``, instead of its origin.

        Raises:
            LookupError: Unknown kind, name or frame.
            ValueError: The point is not three finite numbers.
        """
        kind, _, name = of.partition(":")
        if kind not in self._kinds:
            raise LookupError(f"expected {', '.join(self._kinds)} and a name, got '{of}'")
        find, names = self._kinds[kind]
        if name not in names:
            raise LookupError(f"no {kind} '{name}'{did_you_mean(name, names)}")
        about_root, own = find(name)
        return self._told(about_root, frame or own, axes, point), frame or own

    def _told(self, about_root: Array, frame: str, axes: str, point: ArrayLike | None) -> Array:
        place = self._place(frame)
        if point is not None:
            place = place * pin.SE3(np.eye(3), _finite(point))
        if axes:
            place = pin.SE3(self._place(axes).rotation, place.translation)
        return place.actInv(pin.Force(about_root)).vector

    def _place(self, frame: str) -> pin.SE3:
        """Placement of a frame in the root."""
        joint, place = self._graph.locate(*self._robot.frame(frame))
        return self._graph.data.oMi[joint] * place

    def _about_root(self, frame: str, wrench: Array) -> Array:
        return self._place(frame).act(pin.Force(wrench)).vector

    def _contact(self, name: str) -> tuple[Array, str]:
        contacts = self._observer.contacts
        row = numbered([contact.frame for contact in contacts]).index(name)
        return self._of_contact(row), contacts[row].frame

    def _of_contact(self, row: int) -> Array:
        contact = self._observer.contacts[row]
        joint, place = self._graph.locate(contact.link, contact.placement)
        placed = self._graph.data.oMi[joint] * place
        return placed.act(pin.Force(self.estimate.wrench[row])).vector

    def _subtree(self, name: str) -> tuple[Array, str]:
        names = [subtree.name for subtree in self._robot.subtrees]
        row = names.index(name)
        frame = self._robot.subtrees[row].default_frame
        return self._about_root(frame, self.estimate.subtree_wrench[row]), frame

    def _sensor(self, name: str) -> tuple[Array, str]:
        row = self._robot.ft_sensors.index(name)
        frame = self._robot.ft_frames[row]
        return self._about_root(frame, self.estimate.measured[row]), frame

    def _link(self, name: str) -> tuple[Array, str]:
        inertia = self._robot.urdf.links[name].inertia or pin.Inertia.Zero()
        joint, place = self._graph.locate(name, pin.SE3.Identity())
        data, inside = self._graph.bare_data, place.act(inertia)
        velocity = data.v[joint]
        net = inside * data.a_gf[joint] + velocity.cross(inside * velocity)
        return self._graph.data.oMi[joint].act(net).vector, name

    def _joint(self, name: str) -> tuple[Array, str]:
        graph, index = self._graph, self._robot.joints.index(name)
        joint, child = graph.joint_ids[index], self._robot.urdf.joints[name].child
        through = graph.data.oMi[joint].act(graph.bare_data.f[joint]).vector
        through = through - self._external_below(index)
        is_below = graph.locate(child, pin.SE3.Identity())[0] == joint
        return (through if is_below else -through), child

    def _external_below(self, index: int) -> Array:
        """What the world exerts beyond a joint, as seen from the root; cf. ``SharedSubtree``."""
        graph, own = self._graph, self._graph.joint_subtree[index]
        total = np.zeros(6)
        for row, subtree in enumerate(self._robot.subtrees):
            if row != own and graph.contact_below[index, row]:
                total += self._subtree(subtree.name)[0]
        for row, contact in enumerate(self._observer.contacts):
            parent = graph.locate(contact.link, contact.placement)[0]
            if contact.subtree == own and graph.below([parent])[index, 0]:
                total += self._of_contact(row)
        return total


def _finite(point: ArrayLike) -> Array:
    array = np.asarray(point, dtype=float)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise ValueError(f"a point is three finite numbers [m], got {point}")
    return array
