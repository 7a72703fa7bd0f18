"""Algorithm 1: motion from an inertial sensor to every link, one link at a time.

Reference code in the words of the thesis of Fumagalli, section 3.4.1; the torque observer
does the same in one pass of Pinocchio's Newton-Euler algorithm. Prismatic joints, which
the thesis leaves out, are added to its equations.
"""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from estimation.graph.enhanced_graph import EnhancedGraph
from estimation.graph.graph_parts import Edge, Leaf

Array = np.ndarray
cross = np.cross


@dataclass(frozen=True, eq=False)
class FrameMotion:
    """Motion of a frame, in its own axes.

    ``acceleration`` is that of the frame's origin minus gravity, what an accelerometer
    there would read.
    """

    omega: Array  # (3,) rad/s
    domega: Array  # (3,) rad/s^2
    acceleration: Array  # (3,) m/s^2

    def turned(self, rotation: Array) -> "FrameMotion":
        """Return the same motion in other axes; ``rotation`` maps own to other axes."""
        return FrameMotion(
            rotation @ self.omega, rotation @ self.domega, rotation @ self.acceleration
        )

    def shifted(self, r: Array) -> "FrameMotion":
        """Return the motion of the point at ``r`` (3,) m of the same rigid body."""
        w, dw = self.omega, self.domega
        return FrameMotion(w, dw, self.acceleration + cross(dw, r) + cross(w, cross(w, r)))


def at_rest(gravity: Array) -> FrameMotion:
    """Motion of a fixed link, ``gravity`` (3,) m/s^2 in its axes: the other kinematic source."""
    return FrameMotion(np.zeros(3), np.zeros(3), -np.asarray(gravity, dtype=float))


def solve_kinematics(
    graph: EnhancedGraph, source: Leaf, motion: FrameMotion, q: Array, dq: Array, ddq: Array
) -> dict[str, FrameMotion]:
    """Return the motion of every link's frame, in the order of the visit (Algorithm 1).

    Args:
        graph: The graph.
        source: Black triangle that becomes the root of the tree.
        motion: What it measures.
        q, dq, ddq: Joint motion, (n,) in the robot's order; rad or m, per s, per s^2.
    """
    motions: dict[str, FrameMotion] = {}
    for link, via in graph.pre_order(source.link):
        if via is None:
            motions[link] = same_link(motion, source.placement.inverse())
            continue
        near, cross_over = motions[via.other(link)], along if via.head == link else against
        motions[link] = cross_over(near, via, *(via.of(x) for x in (q, dq, ddq)))
    return motions


def same_link(motion: FrameMotion, placement: pin.SE3) -> FrameMotion:
    """Eq. (3.4.3): from one frame of a link to another at ``placement`` in it."""
    return motion.shifted(placement.translation).turned(placement.rotation.T)


def along(tail: FrameMotion, edge: Edge, q: float, dq: float, ddq: float) -> FrameMotion:
    """Eq. (3.4.1): from a link over an outgoing edge to the next."""
    z, s, edge_m_head = edge.turning, edge.sliding, edge.edge_m_head_at(q)
    fixed = same_link(tail, edge.tail_m_edge).shifted(q * s)
    w = fixed.omega
    moved = FrameMotion(
        w + dq * z,
        fixed.domega + ddq * z + dq * cross(w, z),
        fixed.acceleration + ddq * s + 2.0 * dq * cross(w, s),
    )
    return moved.shifted(edge_m_head.translation - q * s).turned(edge_m_head.rotation.T)


def against(head: FrameMotion, edge: Edge, q: float, dq: float, ddq: float) -> FrameMotion:
    """Eq. (3.4.2): from a link over an ingoing edge to the previous one."""
    z, s, edge_m_head = edge.turning, edge.sliding, edge.edge_m_head_at(q)
    moved = head.turned(edge_m_head.rotation).shifted(q * s - edge_m_head.translation)
    w = moved.omega
    fixed = FrameMotion(
        w - dq * z,
        moved.domega - ddq * z - dq * cross(w, z),
        moved.acceleration - ddq * s - 2.0 * dq * cross(w, s),
    )
    return same_link(fixed.shifted(-q * s), edge.tail_m_edge.inverse())
