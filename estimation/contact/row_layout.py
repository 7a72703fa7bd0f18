"""Where the wrench of a touch appears among a robot's equations of motion.

The robot is re-rooted at its inertial sensor and cut at its force/torque sensors, each
of which becomes a joint of six rows. A wrench F on a body, in the axes and about the
origin of the root, adds J^T F to the rows of the joints between that body and the root,
and nothing to the others; J is the same for all bodies.
"""

from collections.abc import Iterable, Sequence

import numpy as np
import pinocchio as pin

from estimation.residual.residual_model import joint_at, rows_above
from robot_model import Robot
from robot_model.tree import build_tree

Array = np.ndarray


class RowLayout:
    """The cut tree and its constant index sets. Sizes: nv rows, s = k + 1 sub-trees, b bodies.

    Attributes:
        bears: (b, nv) bool, the rows in which a wrench on a body appears; the bodies are
            those of ``robot.links``.
        inlets: (s, 6) rows of the root and of every sensor.
        incidence: (s, s) entries 0, 1, -1: external wrench of a sub-tree from what
            enters through ``inlets``.
        needs: (s, n) bool, the joints whose motion the wrench of a sub-tree depends on.
    """

    def __init__(self, robot: Robot):
        self.robot = robot
        self.tree = build_tree(robot, robot.imus[0], cut=True)
        self.model: pin.Model = self.tree.model
        self.model.gravity.linear = np.zeros(3)  # the accelerometer carries it
        frames = self.model.frames
        joints = [frames[self.tree.frame_id(link)].parentJoint for link in robot.links]
        self.bears = np.array([rows_above(self.model, joint) for joint in joints])
        self.inlets = np.vstack([np.arange(6), self.tree.cut_v])
        self.subtree = np.array([robot.subtree_of(link) for link in robot.links])
        self.incidence = self._incidence()
        self.needs = self._needs()

    def rows_of(self, link: str) -> Array:
        """Return (nv,) bool: the rows in which a wrench on a link or frame appears."""
        return self.bears[self.robot.links.index(self.robot.frame(link)[0])]

    def _incidence(self) -> Array:
        entered = [self._inlet(self.rows_of(tree.links[0])) for tree in self.robot.subtrees]
        incidence = np.zeros((len(entered), len(entered)))
        for row, column in enumerate(entered):
            incidence[row, column] = 1.0
        for i, rows in enumerate(self.tree.cut_v):
            above = rows_above(self.model, self.model.parents[joint_at(self.model, rows[0])])
            incidence[entered.index(self._inlet(above)), i + 1] = -1.0
        return incidence

    def _inlet(self, bears: Array) -> int:
        """Index of the last inlet on the way from the root to a body."""
        depth = [start if bears[start] else -1 for start in self.inlets[:, 0]]
        return int(np.argmax(depth))

    def _needs(self) -> Array:
        """A joint matters to the bodies beyond it, seen from the inertial sensor."""
        beyond = self.bears[:, self.tree.joint_v]
        return np.array([beyond[self.subtree == i].any(axis=0) for i in self.subtrees])

    @property
    def subtrees(self) -> range:
        return range(len(self.robot.subtrees))


class RemovedWrenches:
    """Sub-trees whose net wrench is taken from all rows: supports, and what must not disturb.

    The wrench of a support acts at its frame; that of a blind sub-tree acts anywhere in
    it. Rows between two places where it may act share it in an unknown way, and are
    dropped; so is the sub-tree's own inlet, which told the wrench.

    Args:
        layout: The rows.
        frames: Frames of the supports.
        blind: Indices of further sub-trees.

    Attributes:
        subtrees: Indices of all these sub-trees; touches there are not seen.
        bears: (nv, number of those) 1 where the wrench appears.
        spread: (nv, s) the sum of their wrenches in every row from what enters through the
            inlets.
        active: (nv,) bool, rows that still say something.
    """

    def __init__(self, layout: RowLayout, frames: Sequence[str], blind: Iterable[int] = ()):
        rows: dict[int, list[Array]] = {}
        for frame in frames:
            rows.setdefault(layout.robot.subtree_of(frame), []).append(layout.rows_of(frame))
        rows |= {i: list(layout.bears[layout.subtree == i]) for i in blind}
        self.subtrees = sorted(rows)
        common = [np.logical_and.reduce(rows[i]) for i in self.subtrees]
        self.bears = np.array(common, dtype=float).reshape(len(common), layout.model.nv).T
        self.spread = self.bears @ layout.incidence[self.subtrees]
        self.active = np.ones(layout.model.nv, dtype=bool)
        for i, shared in zip(self.subtrees, common, strict=True):
            inlet = int(np.flatnonzero(layout.incidence[i] > 0.0)[0])
            self.active[layout.inlets[inlet]] = False
            self.active[np.logical_or.reduce(rows[i]) & ~shared] = False
