"""The Enhanced Oriented Graph of a robot, as one Pinocchio model and constant matrices.

This is the form on which the torque observer computes. ``enhanced_graph`` is the graph as
the thesis draws it, to be read and followed link by link; both give the same answers.

The kinematic tree is re-rooted at the inertial sensor and cut at its N force/torque
sensors into N + 1 sub-trees (thesis of Fumagalli, sections 3.3 and 4.1). The net external
wrench of each sub-tree acts on a massless leaf of the tree.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import pinocchio as pin

from estimation.contact_set import Contact, net_contacts, shared_subtrees
from robot_model import Robot
from robot_model.tree import build_tree


class OrientedGraph:
    """Re-rooted, cut model with a contact leaf per sub-tree.

    "Below" is away from the inertial sensor. Sizes: n joints, k sensors, s = k + 1
    sub-trees; column 0 of ``incidence`` is the wrench at the root, column i + 1 that
    through sensor i.
    """

    incidence: np.ndarray  # (s, s) entries 0, 1, -1: sub-tree = what enters - what leaves
    contact_below: np.ndarray  # (n, s) 1 where the leaf of a sub-tree is below a joint
    joint_subtree: np.ndarray  # (n,) sub-tree in which a joint lies

    def __init__(self, robot: Robot, contacts: Sequence[Contact]):
        self.robot = robot
        self.tree = build_tree(robot, robot.imus[0], cut=True)
        self.model: pin.Model = self.tree.model
        model = self.model
        model.gravity = pin.Motion.Zero()  # the accelerometer carries it
        self.bare_model = pin.Model(model)  # without the leaves, which cost time in dynamics
        self.joint_ids = _joint_ids(model, self.tree.joint_v)
        self._cut_ids = _joint_ids(model, self.tree.cut_v[:, 0])
        links = [self.tree.frame_ids[subtree.default_link] for subtree in robot.subtrees]
        self.entry = [self._enter(model.frames[i].parentJoint) for i in links]
        self.incidence = self._incidence()
        self.joint_subtree = np.array([self.entry.index(self._enter(j)) for j in self.joint_ids])
        self._leaves = [self._add_leaf(f"contact_{s.name}") for s in robot.subtrees]
        self.neutral = pin.neutral(model)
        # Shared by all who compute on the graph, one after the other: Pinocchio's data
        # grow with nv^3, here to 50 MB and 0.1 s.
        self.data, self.bare_data = model.createData(), self.bare_model.createData()
        self.place(contacts)

    @property
    def leaf_v(self) -> int:
        """Start in v of the leaves, six each."""
        return self.model.joints[self._leaves[0]].idx_v

    def _add_leaf(self, name: str) -> int:
        # Leaves come last: a parent may then change to any joint and still precede its leaf.
        free = pin.JointModelFreeFlyer()
        return self.model.addJoint(1, free, pin.SE3.Identity(), name)

    def locate(self, link: str, link_m_place: pin.SE3) -> tuple[int, pin.SE3]:
        """Return the model joint that carries a place on a link, and joint_M_place."""
        frame = self.model.frames[self.tree.frame_id(link)]
        return frame.parentJoint, frame.placement * link_m_place

    def place(self, contacts: Sequence[Contact]) -> None:
        """Move each leaf to the first contact of its sub-tree, or to the default frame.

        Takes effect at the next call of a kinematic algorithm.
        """
        for leaf, contact in zip(self._leaves, net_contacts(self.robot, contacts), strict=True):
            parent, placement = self.locate(contact.link, contact.placement)
            self.model.parents[leaf] = parent
            self.model.jointPlacements[leaf] = placement
        self.contact_below = self.below(self._leaves).astype(float)
        self._share_below = self._shares(contacts)

    def _shares(self, contacts: Sequence[Contact]) -> np.ndarray:
        """Return (n, s): which part of the unknown contacts on a sub-tree is below a joint."""
        shares = self.contact_below.copy()
        for row, some in shared_subtrees(self.robot, contacts).items():
            places = [self.locate(c.link, c.placement)[0] for c in some if c.push.free.size]
            inside = self.joint_subtree == row
            part = self.below(places).mean(axis=1) if places else np.zeros(self.robot.n)
            shares[inside, row] = part[inside]
        return shares

    def _chain(self, joint: int) -> list[int]:
        """Return the joints from ``joint`` up to the root, both included."""
        chain = [joint]
        while chain[-1] > 1:
            chain.append(self.model.parents[chain[-1]])
        return chain

    def below(self, joints: Sequence[int]) -> np.ndarray:
        """Return (n, len(joints)): whether a model joint is a joint of the robot or below it."""
        chains = [self._chain(joint) for joint in joints]
        return np.array([[j in chain for chain in chains] for j in self.joint_ids])

    def _enter(self, joint: int) -> int:
        """Column of the wrench through which the sub-tree of a joint hangs on the root's side."""
        cuts = (self._cut_ids.index(j) + 1 for j in self._chain(joint) if j in self._cut_ids)
        return next(cuts, 0)

    def _incidence(self) -> np.ndarray:
        incidence = np.zeros((len(self.entry), len(self.entry)))
        for row, column in enumerate(self.entry):
            incidence[row, column] = 1.0
        for i, cut in enumerate(self._cut_ids):
            outside = self._enter(self.model.parents[cut])
            incidence[self.entry.index(outside), i + 1] = -1.0
        return incidence

    def subtree_joints(self) -> np.ndarray:
        """Return (s, n): whether a sub-tree's wrench needs the motion of a joint.

        It needs the joints between its bodies and the inertial sensor.
        """
        needs = np.zeros((len(self.entry), self.robot.n), dtype=bool)
        for body, subtree in self.bodies:
            needs[subtree] |= self.below([body])[:, 0]
        return needs

    def torque_joints(self) -> np.ndarray:
        """Return (n, n): whether the torque of a joint (row) needs the motion of another.

        The torque balances the bodies below the joint; sub-trees whose contacts are below
        too cancel but for their bodies above the joint.
        """
        needs = np.eye(self.robot.n, dtype=bool)
        for body, subtree in self.bodies:
            path = self.below([body])[:, 0]
            counts = path != self._share_below[:, subtree]
            needs |= counts[:, None] & path[None, :]
        joint_paths = self.below(self.joint_ids)
        sensor_paths = self.below(self._cut_ids)
        return needs | joint_paths.T | (self.torque_sensors() @ sensor_paths.T)

    def prediction_joints(self) -> np.ndarray:
        """Return (k, n): whether a predicted reading needs the motion of a joint."""
        needs = self.below(self._cut_ids).T
        for body, _ in self.bodies:
            chain = self._chain(body)
            beyond = np.array([cut in chain for cut in self._cut_ids])
            needs = needs | (beyond[:, None] & self.below([body]).T)
        return needs

    def torque_sensors(self) -> np.ndarray:
        """Return (n, k): whether the torque of a joint needs a force/torque sensor."""
        return (self._share_below @ self.incidence)[:, 1:] != 0.0

    def subtree_sensors(self) -> np.ndarray:
        """Return (s, k): whether the wrench of a sub-tree needs a force/torque sensor."""
        return self.incidence[:, 1:] != 0.0

    @cached_property
    def body_parameters(self) -> tuple[np.ndarray, np.ndarray]:
        """Pinocchio's dynamic parameters of the bodies (b, 10) and their change with the centre
        of mass (b, 3, 10), the inertia about it being constant."""
        inertias = [self.bare_model.inertias[body] for body, _ in self.bodies]
        parameters = np.array([inertia.toDynamicParameters() for inertia in inertias])
        return parameters, np.array([by_center(inertia) for inertia in inertias])

    @cached_property
    def bodies(self) -> list[tuple[int, int]]:
        """Model joints that carry mass, with their sub-trees."""
        heavy = [j for j in range(1, self._leaves[0]) if self.model.inertias[j].mass > 0.0]
        return [(j, self.entry.index(self._enter(j))) for j in heavy]


def by_center(inertia: pin.Inertia) -> np.ndarray:
    """Return the change (3, 10) of a body's parameters with its centre of mass [1/m].

    The parameters are quadratic in it, so that the central difference is exact.
    """
    moved = [
        pin.Inertia(inertia.mass, inertia.lever + step, inertia.inertia).toDynamicParameters()
        for step in (*np.eye(3), *-np.eye(3))
    ]
    return (np.array(moved[:3]) - np.array(moved[3:])) / 2.0


def _joint_ids(model: pin.Model, starts: np.ndarray) -> list[int]:
    by_start = {model.joints[j].idx_v: j for j in range(1, model.njoints)}
    return [by_start[int(start)] for start in starts]
