"""Sub-trees that bear other than one full wrench: several contacts, fewer unknowns, or none."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from estimation.contact_set import Contact
from estimation.contact_wrenches import ContactPattern, ContactWrenches
from estimation.oriented_graph import OrientedGraph

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Decision:
    """How far the sensors decide the wrenches of c contacts on s sub-trees (N, 3.2.1)."""

    rank: Array  # (s,) combinations of unknowns that the net wrench decides, 0 to 6
    condition: Array  # (s,) by which an error of the net wrench may grow
    decided: Array  # (c,) bool: nothing of the contact's wrench is left open
    undecided: Array  # (d, c, 6) patterns of wrenches that change no reading; N, N m


class SharedSubtree:
    """The contacts of one sub-tree, wherever the robot is.

    Joints of other sub-trees feel the net wrench, which is measured. Joints within feel
    the contacts below them; what no contact explains acts on none of them.

    Args:
        row: The sub-tree.
        contacts: All that are on it.
        first: Place of the first of them among the contacts of the whole robot.
    """

    def __init__(self, graph: OrientedGraph, row: int, contacts: Sequence[Contact], first: int):
        self.row = row
        self.rows = slice(first, first + len(contacts))
        self._pattern = ContactPattern([contact.push for contact in contacts])
        self._places = [graph.locate(c.link, c.placement) for c in contacts]
        default = graph.robot.frame(graph.robot.subtrees[row].default_frame)
        self._default = graph.locate(*default)
        inside = graph.joint_subtree == row
        below = graph.below([joint for joint, _ in self._places])
        self._below = np.where(inside[:, None], below.reshape(len(inside), -1), 0.0)
        self._leaf_below = np.where(inside, graph.contact_below[:, row], 0.0)
        joints = {joint for joint, _ in self._places}
        self._body = joints.pop() if len(joints) == 1 else None  # that bears all of them
        self.rigid = None  # what does not change with the posture, if they share a body
        if self._body is not None:
            self.rigid = self._pattern.at([place for _, place in self._places])

    def at(self, data: pin.Data) -> "Shares":
        """Return how they share a net wrench at the posture of Pinocchio's data."""
        placements = data.oMi
        if self.rigid is not None:
            solution = self.rigid.carried(placements[self._body])
        else:
            placed = [placements[joint] * place for joint, place in self._places]
            solution = self._pattern.at(placed)
        return Shares(solution, self._below, self._leaf_below)

    def about_default_frame(self, wrench: Array, data: pin.Data) -> Array:
        """Return a wrench (6,) about the root, about the sub-tree's default frame."""
        joint, place = self._default
        return (data.oMi[joint] * place).actInv(pin.Force(wrench)).vector


class Shares:
    """The contacts of one sub-tree at one posture; net wrenches are about the root."""

    def __init__(self, solution: ContactWrenches, below: Array, leaf_below: Array):
        self.solution = solution
        self._below, self._leaf_below = below, leaf_below

    def moved(self, wrench: Array, net: Array) -> Array:
        """Return (n, 6, ...): what acts below each joint, besides the net wrench at the leaf.

        Args:
            wrench: Of each contact, in its frame, (c, 6, ...).
            net: (6, ...).
        """
        columns = wrench.reshape(len(wrench), 6, net.size // 6)
        about_root = (self.solution.maps @ columns).reshape(len(wrench), net.size)
        below = self._below @ about_root
        return (below - np.multiply.outer(self._leaf_below, net.ravel())).reshape(-1, *net.shape)


def decision(
    s: int, c: int, shared: Sequence[SharedSubtree], solved: Sequence[ContactWrenches]
) -> Decision:
    """Put together what s sub-trees with c contacts say; one full wrench is always decided."""
    rank, condition, decided = np.full(s, 6.0), np.ones(s), np.ones(c, dtype=bool)
    patterns = np.zeros((sum(len(solution.undecided) for solution in solved), c, 6))
    start = 0
    for subtree, solution in zip(shared, solved, strict=True):
        rank[subtree.row], condition[subtree.row] = solution.rank, solution.condition
        decided[subtree.rows] = solution.decided
        end = start + len(solution.undecided)
        patterns[start:end, subtree.rows] = solution.undecided
        start = end
    return Decision(rank, condition, decided, patterns)
