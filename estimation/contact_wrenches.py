"""Several contacts on one sub-tree: A x = b of Nori et al., section 3.2.1.

Force/torque sensors tell the net external wrench b of a sub-tree, six numbers. Each
contact adds unknowns to x, and columns to A, by what is known of it. Six independent
unknowns follow from b; fewer are fitted; of more, the smallest are taken, and what the
sensors cannot decide is told beside them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class ContactUnknown:
    """A contact at ``placement`` in the frame of the net wrench, and how it may push.

    Its wrench is ``known + free @ x``, about its point and in its axes. The columns of
    ``free`` are orthonormal; forces and moments are not mixed in one column.
    """

    placement: pin.SE3  # body_M_contact
    free: Array  # (6, u)
    known: Array  # (6,) N, N m


def full_wrench(placement: pin.SE3) -> ContactUnknown:
    """A contact of which nothing is known: 6 unknowns."""
    return ContactUnknown(placement, np.eye(6), np.zeros(6))


def pure_force(placement: pin.SE3) -> ContactUnknown:
    """A force without moment about the contact's point: 3 unknowns."""
    return ContactUnknown(placement, np.eye(6)[:, :3], np.zeros(6))


def force_along(placement: pin.SE3, direction: Array) -> ContactUnknown:
    """A force along ``direction`` (3,), contact axes, of any length: 1 unknown.

    Raises:
        ValueError: The direction is zero or not three finite numbers.
    """
    direction = _finite(direction, 3, "direction")
    norm = np.linalg.norm(direction)
    if norm == 0.0:
        raise ValueError("the direction of a force is zero")
    free = np.concatenate([direction / norm, np.zeros(3)])[:, None]
    return ContactUnknown(placement, free, np.zeros(6))


def known_wrench(placement: pin.SE3, wrench: Array) -> ContactUnknown:
    """A contact whose wrench (6,) is measured, by skin for instance: no unknown.

    Raises:
        ValueError: The wrench is not six finite numbers.
    """
    return ContactUnknown(placement, np.zeros((6, 0)), _finite(wrench, 6, "wrench"))


def _finite(values: Array, size: int, what: str) -> Array:
    array = np.asarray(values, dtype=float)
    if array.shape != (size,) or not np.isfinite(array).all():
        raise ValueError(f"expected a {what} of {size} finite numbers, got {values}")
    return array


@dataclass(frozen=True)
class Units:
    """The force and the moment that count as equally large, in errors and in unknowns.

    Newtons and newton metres cannot be added, so the answer of an over- or
    underdetermined sub-tree depends on these two. 1 N against 0.1 N m is a lever of
    0.1 m, the size of a hand.
    """

    force: float = 1.0  # N
    moment: float = 0.1  # N m

    @property
    def wrench(self) -> Array:
        """The unit of each component of a wrench, (6,)."""
        return np.repeat([self.force, self.moment], 3)


@dataclass(frozen=True, eq=False)
class SharedWrench:
    """A net wrench shared among the contacts of a sub-tree; N, N m."""

    wrench: Array  # (c, 6) of the world on the robot, each in its contact's frame
    residual: Array  # (6,) what no choice of the unknowns explains, in the net wrench's frame


class ContactWrenches:
    """The c contacts of one sub-tree at one posture, with u unknowns together.

    Of all x with the least |A x - b| the one with the least |x|, both in ``units``: the
    weighted minimum-norm least squares. Moments of A x - b are taken about the mean
    of the unknown contacts' points; so the answer depends on neither the frame of the net
    wrench nor the order of the contacts.

    Args:
        contacts: Any number of any kind.
        units: Force and moment that count as equally large.
        tolerance: Singular values of A in units below this share of the largest are zero.
    """

    unknowns: int  # u
    rank: int  # how many combinations of the unknowns the net wrench decides, 0 to 6
    condition: float  # largest over least singular value among those; 1 for none
    gain: Array  # (c, 6, 6) change of a contact's wrench with the net wrench
    undecided: Array  # (u - rank, c, 6) patterns of wrenches without net wrench; N, N m
    decided: Array  # (c,) bool: no pattern contains the contact

    def __init__(
        self,
        contacts: Sequence[ContactUnknown],
        units: Units | None = None,
        tolerance: float = 1e-6,
    ):
        scale = (units or Units()).wrench
        self._maps = np.array([c.placement.toDualActionMatrix() for c in contacts])
        self._maps = self._maps.reshape(-1, 6, 6)
        self._known = np.array([c.known for c in contacts]).reshape(-1, 6)
        self._net_known = np.einsum("cij,cj->i", self._maps, self._known)
        pushes = _side_by_side([scale[:, None] * c.free for c in contacts])
        error = pin.SE3(np.eye(3), _middle(contacts)).inverse().toDualActionMatrix()
        self._factorise(pushes, error / scale[:, None], tolerance)

    def _factorise(self, pushes: Array, error: Array, tolerance: float) -> None:
        """Solve for x, in units: contact wrenches are ``pushes`` (c, 6, u) @ x."""
        self.unknowns = pushes.shape[2]
        net = np.einsum("cij,cju->iu", self._maps, pushes)
        left, values, right = np.linalg.svd(error @ net)
        self.rank = rank = int((values > tolerance * values.max(initial=0.0)).sum())
        self.condition = float(values[0] / values[rank - 1]) if rank else 1.0
        inverse = right[:rank].T / values[:rank] @ left[:, :rank].T @ error
        self.gain = pushes @ inverse
        self.undecided = np.einsum("cju,nu->ncj", pushes, right[rank:])
        self._unexplained = np.eye(6) - net @ inverse
        sizes = np.abs(self.undecided).max(axis=(0, 2), initial=0.0)
        self.decided = sizes < 1e-6 * np.abs(pushes).max(initial=1.0)

    def solve(self, net_wrench: Array) -> SharedWrench:
        """Share a net wrench (6,) of the world on the sub-tree; N, N m."""
        sought = net_wrench - self._net_known
        return SharedWrench(self._known + self.gain @ sought, self._unexplained @ sought)


def _side_by_side(blocks: list[Array]) -> Array:
    """Return (c, 6, u): each contact's columns (6, u_c) at their place among all unknowns."""
    ends = np.cumsum([0, *(block.shape[1] for block in blocks)])
    total = np.zeros((len(blocks), 6, ends[-1]))
    for row, block, start, end in zip(total, blocks, ends[:-1], ends[1:], strict=True):
        row[:, start:end] = block
    return total


def _middle(contacts: Sequence[ContactUnknown]) -> Array:
    """Mean point (3,) of the unknown contacts, the origin when there are none."""
    points = [c.placement.translation for c in contacts if c.free.shape[1]]
    return np.mean(points, axis=0) if points else np.zeros(3)
