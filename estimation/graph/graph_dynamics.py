"""Algorithm 2: wrenches from known to unknown edges, one link at a time.

Reference code in the words of the thesis of Fumagalli, section 3.4.2; the torque observer
does the same in one pass of Pinocchio's Newton-Euler algorithm and one Jacobian.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from estimation.graph.enhanced_graph import EnhancedGraph, Step
from estimation.graph.graph_kinematics import Array, FrameMotion, cross
from estimation.graph.graph_parts import Edge, Leaf

Wrenches = dict[str, Array]  # (6,) [f m], N and N m, by edge or leaf


class EdgeWrench(NamedTuple):
    """A wrench on a link: ingoing (+1) acts on it, outgoing (-1) the link exerts."""

    wrench: Array  # (6,) in the frame of its edge
    placement: pin.SE3  # link_M_edge
    sign: float


@dataclass(frozen=True, eq=False)
class GraphWrenches:
    """What Algorithm 2 tells, in the order in which it was found.

    Of an edge: what the tail exerts on the head, in the frame of the edge. Of an unknown:
    what the world exerts on the link, in the frame of the leaf.
    """

    through: Wrenches
    unknown: Wrenches
    torque: Array  # (n,) N m or N, in the robot's order


def solve_wrenches(
    graph: EnhancedGraph,
    motions: Mapping[str, FrameMotion],
    q: Array,
    ft: Array,
    known: Mapping[str, Array] | None = None,
) -> GraphWrenches:
    """Return the wrench of every edge and unknown (Algorithm 2).

    A sub-graph without an unknown gets a fictitious one at its first link, named after
    that link: it comes out zero when model and sensors agree (footnote of section 4.1).

    Args:
        graph: The graph.
        motions: Motion of every link's frame (``solve_kinematics``).
        q: Joint positions, (n,) rad or m.
        ft: Readings, (k, 6) what tails exert on heads, in the sensors' frames.
        known: Wrenches (6,) of the graph's other black rhombi, by name.

    Raises:
        LookupError: The names in ``known`` are not those of the graph.
        ValueError: A sub-graph has two unknowns (``contact_wrenches`` shares them).
    """
    through: Wrenches = {edge.name: ft[edge.index] for edge in graph.sensors}
    unknown: Wrenches = {}
    known = _checked(graph, known)
    for root in _roots(graph):
        for link, via in graph.post_order(root.link, cut=True):
            others = _others(graph, Step(link, via), q, through, known)
            balance = graph.links[link], motions[link], others
            if via is None:
                unknown[root.name] = remaining_wrench(*balance, root.placement, 1.0)
            else:
                through[via.name] = remaining_wrench(*balance, *_end(via, link, q))
    return GraphWrenches(through, unknown, joint_torques(graph, through))


def predict_readings(
    graph: EnhancedGraph,
    motions: Mapping[str, FrameMotion],
    q: Array,
    root: str,
    known: Mapping[str, Array] | None = None,
) -> Array:
    """Return the readings (k, 6) by what lies on the side of each sensor away from ``root``.

    As if nothing touched it there but the ``known`` wrenches; else as ``solve_wrenches``.
    """
    through: Wrenches = {}
    known = _checked(graph, known)
    for link, via in graph.post_order(root):
        if via is not None:
            others = _others(graph, Step(link, via), q, through, known)
            balance = graph.links[link], motions[link], others
            through[via.name] = remaining_wrench(*balance, *_end(via, link, q))
    return np.array([through[edge.name] for edge in graph.sensors]).reshape(-1, 6)


def remaining_wrench(
    inertia: pin.Inertia,
    motion: FrameMotion,
    others: Iterable[EdgeWrench],
    at: pin.SE3,
    sign: float,
) -> Array:
    """Return the one unknown wrench of a link, (6,) in the frame of its edge.

    Eq. (3.4.6) where it goes in (``sign`` +1), (3.4.7) where it goes out (-1): what is
    left of Newton's and Euler's equations (3.4.4) of the link, about its centre of mass.

    Args:
        inertia, motion: Of the link, in its frame.
        others: All other wrenches on the link.
        at: Placement of the unknown's edge in the link.
    """
    center, w = inertia.lever, motion.omega
    f = inertia.mass * motion.shifted(center).acceleration  # (3.4.5)
    m = inertia.inertia @ motion.domega + cross(w, inertia.inertia @ w)
    for wrench, placement, direction in others:
        force = placement.rotation @ wrench[:3]
        moment = placement.rotation @ wrench[3:]
        f = f - direction * force
        m = m - direction * (moment + cross(force, center - placement.translation))
    m = m - cross(f, center - at.translation)
    return sign * np.concatenate([at.rotation.T @ f, at.rotation.T @ m])


def joint_torques(graph: EnhancedGraph, through: Mapping[str, Array]) -> Array:
    """Eq. (4.2.1): the component of each joint's wrench along its axis, (n,) N m or N."""
    screws = ((edge.name, np.concatenate([edge.sliding, edge.turning])) for edge in graph.joints)
    return np.array([through[name] @ screw for name, screw in screws])


def _roots(graph: EnhancedGraph) -> list[Leaf]:
    """The white rhombus of each sub-graph."""
    roots = []
    for links in graph.subgraphs:
        inside = [leaf for leaf in graph.unknown if leaf.link in links]
        if len(inside) > 1:
            names = ", ".join(leaf.name for leaf in inside)
            raise ValueError(f"expected one unknown wrench per sub-graph, got {names} in one")
        fictitious = Leaf(links[0], links[0], pin.SE3.Identity())
        roots.append(inside[0] if inside else fictitious)
    return roots


def _checked(graph: EnhancedGraph, known: Mapping[str, Array] | None) -> Mapping[str, Array]:
    given, expected = set(known or {}), {leaf.name for leaf in graph.known}
    if given != expected:
        raise LookupError(f"known wrenches: expected {sorted(expected)}, got {sorted(given)}")
    return known or {}


def _others(
    graph: EnhancedGraph,
    step: Step,
    q: Array,
    through: Mapping[str, Array],
    known: Mapping[str, Array],
) -> list[EdgeWrench]:
    """All wrenches on a link but the one of the edge that the visit takes next."""
    link, via = step
    edges = (edge for edge in graph.edges_of[link] if edge is not via)
    on_edges = [EdgeWrench(through[edge.name], *_end(edge, link, q)) for edge in edges]
    leaves = (leaf for leaf in graph.known if leaf.link == link)
    return on_edges + [EdgeWrench(known[leaf.name], leaf.placement, 1.0) for leaf in leaves]


def _end(edge: Edge, link: str, q: Array) -> tuple[pin.SE3, float]:
    """Placement of an edge's frame in a link, and whether it goes in (+1) or out (-1)."""
    return edge.placement_in(link, q), 1.0 if edge.head == link else -1.0
