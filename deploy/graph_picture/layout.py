"""Where the nodes of a graph lie in its picture: a tree that grows to the right.

A node lies one column beyond the one nearer to the root; ends take rows in their order,
and what branches sits in the middle of its branches. Every picture of a graph comes out
the same.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum

from deploy.graph_picture.view import View
from estimation.graph.enhanced_graph import EnhancedGraph
from estimation.graph.graph_parts import Edge, Leaf

SYMBOL_DISTANCE = 0.6  # columns between a link and its triangles and rhombi


class Shape(StrEnum):
    """What a node is (Figure 3.6 of the thesis)."""

    link = "link"
    sublink = "sub-link"
    inertial = "inertial sensor"
    motion = "motion to be found"
    known = "known wrench (F/T sensor)"
    unknown = "unknown wrench"


@dataclass(eq=False)
class Node:
    """A node of the picture; columns and rows are counted from the upper left corner."""

    shape: Shape
    label: str
    subgraph: int
    via: Edge | None = None  # edge to the node nearer to the root
    children: list["Node"] = field(default_factory=list)
    column: float = 0.0
    row: float = 0.0

    def below(self) -> Iterator["Node"]:
        """The node and everything beyond it."""
        yield self
        for child in self.children:
            yield from child.below()


def lay_out(graph: EnhancedGraph, root: str, view: View = View.all) -> Node:
    """Return the root node of a picture in which every node has its place."""
    nodes = _link_nodes(graph, cut=view is not View.kinematic)
    for step in graph.pre_order(root):
        if step.via is not None:
            node = nodes[step.link]
            node.via = step.via
            nodes[step.via.other(step.link)].children.append(node)
    if view is not View.dynamic:
        _hang(nodes, graph.inertial, Shape.inertial)
        for link in graph.kinematic_ends:
            nodes[link].children.append(Node(Shape.motion, "", nodes[link].subgraph))
    if view is not View.kinematic:
        _hang(nodes, graph.known, Shape.known)
        _hang(nodes, graph.unknown, Shape.unknown)
    _place(nodes[root], 0.0, 0.0)
    return nodes[root]


def _link_nodes(graph: EnhancedGraph, cut: bool) -> dict[str, Node]:
    sides = {link for edge in graph.sensors for link in (edge.tail, edge.head)} if cut else set()
    return {
        link: Node(Shape.sublink if link in sides else Shape.link, link, subgraph)
        for subgraph, links in enumerate(graph.subgraphs)
        for link in links
    }


def _hang(nodes: dict[str, Node], leaves: tuple[Leaf, ...], shape: Shape) -> None:
    for leaf in leaves:
        node = nodes[leaf.link]
        node.children.append(Node(shape, leaf.name, node.subgraph))


def _place(node: Node, column: float, row: float) -> float:
    """Place a node and all beyond it from ``row`` on; return the first free row."""
    node.column = column
    free = row
    for child in node.children:
        distance = 1.0 if child.via is not None else SYMBOL_DISTANCE
        free = _place(child, column + distance, free)
    if not node.children:
        node.row = row
        return row + 1.0
    node.row = (node.children[0].row + node.children[-1].row) / 2.0
    return free
