"""Wrenches on and in a robot at one sample, each where it is found, with its errors."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from estimation.inner_covariance import on_link, through_joint
from estimation.observer_covariance import ErrorMaps, ObserverNoise
from estimation.torque_observer import TorqueObserver

Array = np.ndarray


class FoundWrench(NamedTuple):
    """A wrench [f m], N and N m, about the origin and in the axes of ``place``."""

    frame: str  # its own: in which it is told where no other is asked for
    place: pin.SE3  # root_M_place
    wrench: Array  # (6,)
    errors: Array  # (6, e) its changes by one standard deviation of each error
    patterns: Array  # (d, 6) of it that change no reading, some of them 0


class FoundWrenches:
    """Finds wrenches in one sample of an observer, until its next step.

    All are counted as the robot and the observer's contacts are.

    Args:
        observer: Computes the sample anew.
        noise, source: As in ``propagate``.
        sample: Arguments of the observer's step.
    """

    def __init__(
        self,
        observer: TorqueObserver,
        noise: ObserverNoise,
        sample: tuple[Array, ...],
        source: Array | None = None,
    ):
        q, dq, ddq, _, *inertial = sample
        motion = observer.motion(q, dq, ddq, *inertial)
        self._maps = ErrorMaps(observer, motion, noise, source)
        self.estimate = observer.step(*sample)
        self._observer, self._graph, self._robot = observer, observer.graph, observer.robot
        self._decided = np.zeros((0, 6))

    def place(self, frame: str) -> pin.SE3:
        """Return the placement of a URDF link or frame in the root."""
        joint, place = self._graph.locate(*self._robot.frame(frame))
        return self._graph.data.oMi[joint] * place

    def contact(self, row: int) -> FoundWrench:
        """Return what the world exerts at a contact."""
        contact = self._observer.contacts[row]
        joint, inside = self._graph.locate(contact.link, contact.placement)
        place = self._graph.data.oMi[joint] * inside
        wrench, errors = self.estimate.wrench[row], self._maps.wrench[row]
        return FoundWrench(contact.frame, place, wrench, errors, self._patterns[:, row])

    def subtree(self, row: int) -> FoundWrench:
        """Return what the world exerts on a sub-tree."""
        frame = self._robot.subtrees[row].default_frame
        wrench, errors = self.estimate.subtree_wrench[row], self._maps.net[row]
        return FoundWrench(frame, self.place(frame), wrench, errors, self._decided)

    def sensor(self, row: int) -> FoundWrench:
        """Return a reading without its offset."""
        frame = self._robot.ft_frames[row]
        wrench, errors = self.estimate.measured[row], np.diag(self._maps.noise.reading)
        return FoundWrench(frame, self.place(frame), wrench, errors, self._decided)

    def link(self, row: int) -> FoundWrench:
        """Return the sum of all that acts on a link, counted as in the URDF."""
        link = list(self._robot.urdf.links.values())[row]
        joint, place = self._graph.locate(link.name, pin.SE3.Identity())
        data = self._graph.bare_data
        inside = place.act(link.inertia or pin.Inertia.Zero())
        velocity = data.v[joint]
        net = inside * data.a_gf[joint] + velocity.cross(inside * velocity)
        wrench = self._graph.data.oMi[joint].act(net).vector
        errors = on_link(self._maps, joint, inside)
        return FoundWrench(link.name, pin.SE3.Identity(), wrench, errors, self._decided)

    def joint(self, index: int) -> FoundWrench:
        """Return what a joint's parent exerts on its child."""
        graph, name = self._graph, self._robot.joints[index]
        joint, child = graph.joint_ids[index], self._robot.urdf.joints[name].child
        through = graph.data.oMi[joint].act(graph.bare_data.f[joint]).vector
        external, patterns = self._external_below(index)
        is_below = graph.locate(child, pin.SE3.Identity())[0] == joint
        wrench = through - external if is_below else external - through
        errors = through_joint(self._maps, index)
        return FoundWrench(child, pin.SE3.Identity(), wrench, errors, patterns)

    @property
    def _patterns(self) -> Array:
        """Patterns of the contacts' wrenches that change no reading, (d, c, 6)."""
        decision = self.estimate.decision
        nothing = np.zeros((0, len(self._observer.contacts), 6))
        return nothing if decision is None else decision.undecided

    def _external_below(self, index: int) -> tuple[Array, Array]:
        """What the world exerts beyond a joint, (6,) about the root, and its patterns (d, 6).

        A joint feels the net wrench of other sub-trees, and of its own the contacts beyond
        it; cf. ``SharedSubtree``.
        """
        graph, own = self._graph, self._graph.joint_subtree[index]
        total, patterns = np.zeros(6), np.zeros((len(self._patterns), 6))
        for row in np.flatnonzero(graph.contact_below[index]).tolist():
            if row != own:
                net = self.subtree(row)
                total += net.place.toDualActionMatrix() @ net.wrench
        for row, contact in enumerate(self._observer.contacts):
            bearer = graph.locate(contact.link, contact.placement)[0]
            if contact.subtree == own and graph.below([bearer])[index, 0]:
                found = self.contact(row)
                to_root = found.place.toDualActionMatrix()
                total += to_root @ found.wrench
                patterns += found.patterns @ to_root.T
        return total, patterns
