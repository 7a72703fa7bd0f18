"""Support wrenches that hold a resting robot up, shared as the supports are loaded."""

from typing import NamedTuple

import numpy as np

MARGIN = 0.005  # m, kept between a centre of pressure and the edge of its sole


class SoleBox(NamedTuple):
    """Where the centre of pressure of a support may lie, in the support frame."""

    low: np.ndarray  # (2,) m
    high: np.ndarray  # (2,) m


class Preference(NamedTuple):
    """How far each component of a support's wrench may stray from the wanted one.

    Square roots of inverse weights, for a support that bears everything; relative to
    each other only. The vertical force is held to the load sharing; tangential forces
    and moments give what balance needs.
    """

    tangential: float = 1.0  # N
    vertical: float = 0.2  # N
    tilting: float = 0.05  # N m
    twisting: float = 0.02  # N m


class SupportWrenches(NamedTuple):
    """Wrenches (s, 6) of the world on the supports, in their frames, and whether they can be."""

    wrench: np.ndarray
    feasible: bool


def sole_box(corners: np.ndarray | None) -> SoleBox | None:
    """Return the box of sole corners (c, 3) m less the margin; None if there are none."""
    if corners is None:
        return None
    return SoleBox(corners[:, :2].min(axis=0) + MARGIN, corners[:, :2].max(axis=0) - MARGIN)


def share_support(
    maps: np.ndarray,
    demand: np.ndarray,
    shares: np.ndarray,
    boxes: list[SoleBox | None],
    preference: Preference | None = None,
) -> SupportWrenches:
    """Distribute the wrench that holds the base over the supports.

    Weighted least squares around vertical forces in the given shares, under base
    equilibrium and with centres of pressure inside the soles: a centre that would leave
    its sole is held at the edge, and the rest solved again.

    Args:
        maps: (s, 6, 6) from a wrench in a support frame to the base's wrench.
        demand: Wrench that the supports together must exert on the base, (6,).
        shares: Part of the vertical load that each support bears, (s,), adding up to 1.
        boxes: Sole of each support; None where any wrench can be transmitted.
        preference: Weights.

    Returns:
        Wrenches; not feasible when no unilateral wrench inside the soles balances.
    """
    count = len(maps)
    spread = _spread(shares, preference or Preference())
    balance = maps.transpose(1, 0, 2).reshape(6, 6 * count)
    wanted = np.zeros((count, 6))
    wanted[:, 2] = shares * np.linalg.norm(demand[:3])
    edges: dict[tuple[int, int], np.ndarray] = {}
    for _ in range(2 * count + 1):
        rows = np.vstack([balance, *edges.values()])
        right = np.concatenate([demand, np.zeros(len(edges))])
        wrench = _nearest(rows, right, wanted.ravel(), spread).reshape(count, 6)
        crossed = _crossed_edges(wrench, boxes)
        if not set(crossed) - set(edges):
            break
        edges |= crossed
    missing = np.linalg.norm(demand - np.einsum("sij,sj->i", maps, wrench))
    balanced = bool(missing < 1e-3 * np.linalg.norm(demand))
    return SupportWrenches(wrench, balanced and _unilateral(wrench, boxes))


def _spread(shares: np.ndarray, p: Preference) -> np.ndarray:
    """Variances (6 s,): a support strays in proportion to its share of the load."""
    one = np.square([p.tangential, p.tangential, p.vertical, p.tilting, p.tilting, p.twisting])
    return np.kron(np.maximum(shares, 1e-3), one)


def _nearest(
    rows: np.ndarray, right: np.ndarray, wanted: np.ndarray, spread: np.ndarray
) -> np.ndarray:
    """Return the x nearest to ``wanted`` (metric 1 / spread) with rows @ x = right."""
    weighted = rows * spread
    step = np.linalg.lstsq(weighted @ rows.T, right - rows @ wanted, rcond=1e-12)[0]
    return wanted + weighted.T @ step


def _crossed_edges(
    wrench: np.ndarray, boxes: list[SoleBox | None]
) -> dict[tuple[int, int], np.ndarray]:
    """Rows that hold each centre of pressure that left its sole at the edge."""
    edges = {}
    for i, box in enumerate(boxes):
        if box is None or wrench[i, 2] <= 0.0:
            continue
        center = np.array([-wrench[i, 4], wrench[i, 3]]) / wrench[i, 2]
        held = np.minimum(np.maximum(center, box.low), box.high)
        for axis in np.flatnonzero(np.abs(held - center) > 1e-9):
            row = np.zeros(wrench.size)
            row[6 * i + 2] = held[axis]
            row[6 * i + (4 if axis == 0 else 3)] = 1.0 if axis == 0 else -1.0
            edges[i, int(axis)] = row[None]
    return edges


def _unilateral(wrench: np.ndarray, boxes: list[SoleBox | None]) -> bool:
    """Whether every sole pushes, up to a hundredth of the whole load."""
    slack = -0.01 * float(np.abs(wrench[:, 2]).sum())
    return all(box is None or wrench[i, 2] >= slack for i, box in enumerate(boxes))
