"""Edges and leaves of the Enhanced Oriented Graph (thesis of Fumagalli, section 3.3.1)."""

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin


@dataclass(frozen=True, eq=False)
class Edge:
    """An oriented edge <e> from link ``tail`` to link ``head``.

    Its frame is fixed in the tail. The wrench that it carries is what the tail exerts on
    the head, about the origin and in the axes of that frame (section 3.3.1).
    """

    name: str  # of the URDF joint, or of the sensor
    kind: str  # revolute, prismatic or sensor
    index: int  # among the robot's joints, or among its force/torque sensors
    tail: str
    head: str
    tail_m_edge: pin.SE3
    edge_m_head: pin.SE3  # at zero position
    axis: np.ndarray  # (3,) unit vector, edge axes; zero for a sensor

    @property
    def turning(self) -> np.ndarray:
        """Axis (3,) of rotation, zero where there is none."""
        return self.axis * (self.kind == "revolute")

    @property
    def sliding(self) -> np.ndarray:
        """Axis (3,) of translation, zero where there is none."""
        return self.axis * (self.kind == "prismatic")

    def of(self, values: np.ndarray) -> float:
        """Return a joint's entry of a vector in the robot's order; a sensor never moves."""
        return 0.0 if self.kind == "sensor" else float(values[self.index])

    def edge_m_head_at(self, position: float) -> pin.SE3:
        """Return the placement of the head in the edge's frame at a position (rad or m)."""
        turn, slide = pin.exp3(self.turning * position), self.sliding * position
        return pin.SE3(turn, slide) * self.edge_m_head

    def placement_in(self, link: str, q: np.ndarray) -> pin.SE3:
        """Return link_M_edge in the tail or the head, joints at ``q`` (n,)."""
        if link == self.tail:
            return self.tail_m_edge
        return self.edge_m_head_at(self.of(q)).inverse()

    def other(self, link: str) -> str:
        """Return the link at the other end."""
        return self.head if link == self.tail else self.tail

    def turned(self) -> "Edge":
        """Return the same joint as an edge from head to tail; its position keeps its sign."""
        return replace(
            self,
            tail=self.head,
            head=self.tail,
            tail_m_edge=self.edge_m_head.inverse(),
            edge_m_head=self.tail_m_edge.inverse(),
            axis=-self.axis,
        )


@dataclass(frozen=True, eq=False)
class Leaf:
    """A triangle or rhombus at a link; the wrench of a rhombus is the world's on the link."""

    name: str
    link: str
    placement: pin.SE3  # link_M_leaf
