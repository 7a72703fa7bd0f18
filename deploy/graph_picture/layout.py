"""Where the nodes of a graph lie in its picture: a tree that grows to the right.

A node lies one column beyond the one nearer to the root; the rows are those of a tidy
tree (Reingold and Tilford), in which what branches sits in the middle of its branches.
Every picture of a graph comes out the same.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum

import bigtree

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
    _place(nodes[root])
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


def _place(root: Node) -> None:
    """Give every node its column and row."""
    nodes = list(root.below())
    points = {id(node): bigtree.Node(str(i)) for i, node in enumerate(nodes)}
    for node in nodes:
        points[id(node)].children = [points[id(child)] for child in node.children]
    bigtree.reingold_tilford(points[id(root)])
    for node in nodes:
        node.row = points[id(node)].get_attr("x")
        for child in node.children:
            child.column = node.column + (1.0 if child.via is not None else SYMBOL_DISTANCE)
