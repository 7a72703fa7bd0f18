"""Support wrenches that hold a resting robot up, shared as the supports are loaded."""

import math
from typing import NamedTuple

import numpy as np

MARGIN = 0.005  # m, kept between a centre of pressure and the edge of its sole


# How far each component of a support's wrench may stray from the wanted one: square roots
# of inverse weights, N and N m, for a support that bears everything; relative to each other
# only. The vertical force is held to the load sharing; tangential forces and moments give
# what balance needs.
PREFERENCE = np.array([1.0, 1.0, 0.2, 0.05, 0.05, 0.02])
SPREAD = PREFERENCE**2


class SoleBox(NamedTuple):
    """Where the centre of pressure of a support may lie, x and y in the support frame."""

    low: tuple[float, float]  # m
    high: tuple[float, float]  # m


class SupportWrenches(NamedTuple):
    """Wrenches (s, 6) of the world on the supports, in their frames, and whether they can be."""

    wrench: np.ndarray
    feasible: bool


def sole_box(corners: np.ndarray | None, margin: float = MARGIN) -> SoleBox | None:
    """Return the box of sole corners (c, 3) m less the margin; None if there are none."""
    if corners is None:
        return None
    (left, low, _), (right, high, _) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    return SoleBox((left + margin, low + margin), (right - margin, high - margin))


def share_support(
    balance: np.ndarray, demand: np.ndarray, shares: np.ndarray, boxes: list[SoleBox | None]
) -> SupportWrenches:
    """Distribute the wrench that holds the base over the supports.

    Weighted least squares around vertical forces in the given shares, under base
    equilibrium and with centres of pressure inside the soles: a centre that would leave
    its sole is held at the edge, and the rest solved again.

    Args:
        balance: (6, 6 s) from the wrenches in the support frames to the base's wrench.
        demand: Wrench that the supports together must exert on the base, (6,).
        shares: Part of the vertical load that each support bears, (s,), adding up to 1.
        boxes: Sole of each support; None where any wrench can be transmitted.

    Returns:
        Wrenches; not feasible when no unilateral wrench inside the soles balances.
    """
    # A support strays in proportion to its share of the load.
    spread = (np.maximum(shares, 1e-3)[:, None] * SPREAD).ravel()
    wanted = np.zeros(balance.shape[1])
    wanted[2::6] = shares * math.hypot(*demand[:3].tolist())
    rows, right = balance, demand
    edges: dict[tuple[int, int], np.ndarray] = {}
    for _ in range(2 * len(boxes) + 1):
        wrench = _nearest(rows, right, wanted, spread)
        crossed = _crossed_edges(wrench, boxes)
        if crossed.keys() <= edges.keys():
            break
        edges |= crossed
        rows = np.vstack([balance, *edges.values()])
        right = np.concatenate([demand, np.zeros(len(edges))])
    missing = demand - balance @ wrench
    balanced = bool(missing @ missing < 1e-6 * (demand @ demand))
    return SupportWrenches(wrench.reshape(-1, 6), balanced and _unilateral(wrench, boxes))


def _nearest(
    rows: np.ndarray, right: np.ndarray, wanted: np.ndarray, spread: np.ndarray
) -> np.ndarray:
    """Return the x nearest to ``wanted`` (metric 1 / spread) with rows @ x = right."""
    weighted = rows * spread
    square, missing = weighted @ rows.T, right - rows @ wanted
    if len(rows) == 6:  # balance alone, which one support can always give
        return wanted + np.linalg.solve(square, missing) @ weighted
    return wanted + np.linalg.lstsq(square, missing, rcond=1e-12)[0] @ weighted


def _crossed_edges(
    wrench: np.ndarray, boxes: list[SoleBox | None]
) -> dict[tuple[int, int], np.ndarray]:
    """Rows that hold each centre of pressure that left its sole at the edge."""
    edges = {}
    for i, (box, row) in enumerate(zip(boxes, wrench.reshape(-1, 6).tolist(), strict=True)):
        _, _, fz, mx, my, _ = row
        if box is None or fz <= 0.0:
            continue
        for axis, center in enumerate((-my / fz, mx / fz)):
            held = min(max(center, box.low[axis]), box.high[axis])
            if abs(held - center) > 1e-9:
                edges[i, axis] = _edge(i, axis, held, len(wrench))
    return edges


def _edge(support: int, axis: int, held: float, size: int) -> np.ndarray:
    """Row (size,) that holds a centre of pressure on one axis, x or y [m]."""
    row = np.zeros(size)
    row[6 * support + 2] = held
    row[6 * support + (4 if axis == 0 else 3)] = 1.0 if axis == 0 else -1.0
    return row


def _unilateral(wrench: np.ndarray, boxes: list[SoleBox | None]) -> bool:
    """Whether every sole pushes, up to a hundredth of the whole load."""
    vertical = wrench[2::6].tolist()
    slack = -0.01 * sum(map(abs, vertical))
    return all(box is None or f >= slack for box, f in zip(boxes, vertical, strict=True))
