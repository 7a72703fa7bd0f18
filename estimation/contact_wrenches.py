"""Several contacts on one sub-tree: A x = b of Nori et al., section 3.2.1.

Force/torque sensors tell the net external wrench b of a sub-tree, six numbers. Each
contact adds unknowns to x, and columns to A, by what is known of it. Six independent
unknowns follow from b; fewer are fitted; of more, the smallest are taken, and what the
sensors cannot decide is told beside them.
"""

from collections.abc import Sequence
from copy import copy
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


class ContactPattern:
    """What c contacts leave unknown, u numbers together, wherever they are.

    Args:
        contacts: Any number of any kind; their placements do not matter.
        units: Force and moment that count as equally large.
        tolerance: Singular values of A in units below this share of the largest are zero.
    """

    def __init__(
        self,
        contacts: Sequence[ContactUnknown],
        units: Units | None = None,
        tolerance: float = 1e-6,
    ):
        self.scale = (units or Units()).wrench
        self.tolerance = tolerance
        self.known = np.array([c.known for c in contacts]).reshape(-1, 6)
        self.pushes = _block_diagonal([self.scale[:, None] * c.free for c in contacts])
        self.negligible = 1e-6 * np.abs(self.pushes).max(initial=1.0)
        free = np.array([c.free.shape[1] > 0 for c in contacts], dtype=float)
        self.middle = free / max(1.0, free.sum())  # (c,) weights of the unknown contacts' points
        self.nothing = np.zeros((0, len(contacts), 6))
        self.all = np.ones(len(contacts), dtype=bool)

    def at(self, placements: Sequence[pin.SE3]) -> "ContactWrenches":
        """Return how the contacts share a net wrench, each at its body_M_contact."""
        return ContactWrenches(self, placements)


def contact_wrenches(
    contacts: Sequence[ContactUnknown], units: Units | None = None, tolerance: float = 1e-6
) -> "ContactWrenches":
    """Return how contacts share a net wrench where they are; arguments of `ContactPattern`."""
    return ContactPattern(contacts, units, tolerance).at([c.placement for c in contacts])


class ContactWrenches:
    """The c contacts of one sub-tree at one posture, with u unknowns together.

    Of all x with the least |A x - b| the one with the least |x|, both in units: the
    weighted minimum-norm least squares. Moments of A x - b are taken about the mean
    of the unknown contacts' points; so the answer depends on neither the frame of the net
    wrench nor the order of the contacts.
    """

    unknowns: int  # u
    rank: int  # how many combinations of the unknowns the net wrench decides, 0 to 6
    condition: float  # largest over least singular value among those; 1 for none
    gain: Array  # (c, 6, 6) change of a contact's wrench with the net wrench
    undecided: Array  # (u - rank, c, 6) patterns of wrenches without net wrench; N, N m
    decided: Array  # (c,) bool: no pattern contains the contact
    maps: Array  # (c, 6, 6) from a contact's wrench to the frame of the net wrench

    def __init__(self, pattern: ContactPattern, placements: Sequence[pin.SE3]):
        c = len(placements)
        points = np.array([p.translation for p in placements]).reshape(c, 3)
        self.maps = np.array([p.toDualActionMatrix() for p in placements]).reshape(c, 6, 6)
        wide = self.maps.transpose(1, 0, 2).reshape(6, 6 * c)
        self._known = pattern.known
        self._net_known = wide @ pattern.known.ravel()
        error = _error(pattern.middle @ points, pattern.scale)
        self._factorise(pattern, wide @ pattern.pushes, error)

    def _factorise(self, pattern: ContactPattern, net: Array, error: Array) -> None:
        """Solve for x, in units: wrenches are ``pushes`` (6 c, u) @ x, their sum ``net`` @ x."""
        pushes = pattern.pushes
        self.unknowns = u = pushes.shape[1]
        left, values, right = np.linalg.svd(error @ net, full_matrices=u > 6)
        bound = pattern.tolerance * values[0] if u else 0.0
        self.rank = rank = int(np.count_nonzero(values > bound))
        self.condition = float(values[0] / values[rank - 1]) if rank else 1.0
        inverse = right[:rank].T @ ((left[:, :rank].T / values[:rank, None]) @ error)
        self.gain = (pushes @ inverse).reshape(-1, 6, 6)
        self._unexplained = None if rank == 6 else np.eye(6) - net @ inverse
        self.undecided, self.decided = pattern.nothing, pattern.all
        if u > rank:
            self.undecided = (right[rank:] @ pushes.T).reshape(u - rank, -1, 6)
            self.decided = np.abs(self.undecided).max(axis=(0, 2)) < pattern.negligible

    def carried(self, to_m_here: pin.SE3) -> "ContactWrenches":
        """Return the same for net wrenches in another frame, to which the contacts are fixed."""
        forward, back = to_m_here.toDualActionMatrix(), to_m_here.inverse().toDualActionMatrix()
        moved = copy(self)
        moved.maps, moved.gain = forward @ self.maps, self.gain @ back
        moved._net_known = forward @ self._net_known
        if self._unexplained is not None:
            moved._unexplained = forward @ self._unexplained @ back
        return moved

    def solve(self, net_wrench: Array) -> SharedWrench:
        """Share a net wrench (6,) of the world on the sub-tree; N, N m."""
        sought = net_wrench - self._net_known
        residual = np.zeros(6) if self._unexplained is None else self._unexplained @ sought
        return SharedWrench(self._known + self.gain @ sought, residual)


def _block_diagonal(blocks: list[Array]) -> Array:
    """Return (6 c, u): each contact's columns (6, u_c) in rows of its own."""
    if not blocks:
        return np.zeros((0, 0))
    columns = np.hstack(blocks)  # (6, u)
    owner = np.repeat(np.arange(len(blocks)), [block.shape[1] for block in blocks])
    placed = np.zeros((len(blocks), 6, len(owner)))
    placed[owner, :, np.arange(len(owner))] = columns.T
    return placed.reshape(6 * len(blocks), len(owner))


def _error(point: Array, scale: Array) -> Array:
    """Return the map of a net wrench to an error in units, with moments about a point."""
    x, y, z = point.tolist()
    error = np.eye(6)
    error[3:, :3] = (0.0, z, -y), (-z, 0.0, x), (y, -x, 0.0)
    return error / scale[:, None]
