"""The Enhanced Oriented Graph of a robot as the thesis of Fumagalli draws it.

Nodes are links, or the two sub-links of a link that a force/torque sensor cuts; edges are
joints and sensors, each with a direction that is a convention only; triangles are
inertial sensors, rhombi wrenches (sections 3.3 and 4.1, Figure 3.6). Here the graph is to
be read, drawn and followed one link at a time (``graph_kinematics``,
``graph_dynamics``). ``oriented_graph`` is the same graph as one Pinocchio model and
constant matrices, which is what the torque observer computes on.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from estimation.contact_set import Contact
from estimation.graph.graph_parts import Edge, Leaf
from robot_model import Robot
from robot_model.names import did_you_mean
from robot_model.urdf import Joint


class Step(NamedTuple):
    """A link in the order of a visit, and the edge to the link nearer to the root."""

    link: str
    via: Edge | None


@dataclass(frozen=True, eq=False)
class EnhancedGraph:
    """Links, edges and the symbols of Figure 3.6; made by ``enhanced_graph``.

    White triangles need no entry: every link has a frame of its own, in which its motion
    is told. ``kinematic_ends`` are the links where the thesis draws one.
    """

    links: Mapping[str, pin.Inertia]  # of every link or sub-link, in its frame
    edges: tuple[Edge, ...]  # joints and force/torque sensors
    inertial: tuple[Leaf, ...]  # black triangles; the first is the kinematic source
    unknown: tuple[Leaf, ...] = ()  # white rhombi
    known: tuple[Leaf, ...] = ()  # black rhombi besides the force/torque sensors

    @cached_property
    def joints(self) -> tuple[Edge, ...]:
        """Joints in the robot's order."""
        joints = (edge for edge in self.edges if edge.kind != "sensor")
        return tuple(sorted(joints, key=lambda edge: edge.index))

    @cached_property
    def sensors(self) -> tuple[Edge, ...]:
        """Force/torque sensors in the robot's order; tails are URDF parents."""
        sensors = (edge for edge in self.edges if edge.kind == "sensor")
        return tuple(sorted(sensors, key=lambda edge: edge.index))

    @cached_property
    def edges_of(self) -> Mapping[str, tuple[Edge, ...]]:
        """Edges that enter or leave a link, by link."""
        touching: dict[str, list[Edge]] = {link: [] for link in self.links}
        for edge in self.edges:
            touching[edge.tail].append(edge)
            touching[edge.head].append(edge)
        return {link: tuple(edges) for link, edges in touching.items()}

    @cached_property
    def kinematic_ends(self) -> tuple[str, ...]:
        """Links with ingoing edges only: those with a white triangle (section 4.1, step 3)."""
        tails = {edge.tail for edge in self.edges} | {leaf.link for leaf in self.inertial}
        return tuple(link for link in self.links if link not in tails)

    @cached_property
    def subgraphs(self) -> tuple[tuple[str, ...], ...]:
        """Links of each sub-graph that the sensors cut off: the robot's sub-trees."""
        starts = [sensor.head for sensor in self.sensors]
        reached = [tuple(step.link for step in self.pre_order(link, cut=True)) for link in starts]
        inside = {link for links in reached for link in links}
        root = tuple(link for link in self.links if link not in inside)
        return (root, *reached)

    def pre_order(self, root: str, cut: bool = False) -> Iterator[Step]:
        """Visit every link after the one nearer to ``root``; ``cut`` ends at sensors."""
        stack: list[Step] = [Step(root, None)]
        while stack:
            step = stack.pop()
            yield step
            stack += reversed(list(self._beyond(step, cut)))

    def post_order(self, root: str, cut: bool = False) -> Iterator[Step]:
        """Visit every link before the one nearer to ``root``; ``cut`` ends at sensors."""
        stack: list[tuple[Step, bool]] = [(Step(root, None), False)]
        while stack:
            step, opened = stack.pop()
            if opened:
                yield step
                continue
            stack.append((step, True))
            stack += [(beyond, False) for beyond in self._beyond(step, cut)][::-1]

    def _beyond(self, step: Step, cut: bool) -> Iterator[Step]:
        for edge in self.edges_of[step.link]:
            if edge is not step.via and not (cut and edge.kind == "sensor"):
                yield Step(edge.other(step.link), edge)

    def turned(self, names: Iterable[str]) -> "EnhancedGraph":
        """Return the graph with the edges of these joints in the other direction.

        Raises:
            LookupError: No such joint; a sensor keeps the direction of its reading.
        """
        turn, joints = set(names), {edge.name for edge in self.joints}
        for name in turn - joints:
            raise LookupError(f"no joint '{name}' to turn{did_you_mean(name, joints)}")
        edges = (edge.turned() if edge.name in turn else edge for edge in self.edges)
        return replace(self, edges=tuple(edges))


def enhanced_graph(robot: Robot, contacts: Iterable[Contact] = ()) -> EnhancedGraph:
    """Return the graph of a robot, edges from URDF parent to child.

    Args:
        robot: The robot.
        contacts: Where unknown wrenches act (``contact_set`` gives one per sub-tree).
    """
    sensors = {element.joint: i for i, element in enumerate(robot.ft_elements)}
    joints = {name: i for i, name in enumerate(robot.joints)}
    edges = [
        _sensor(robot, joint, sensors[joint.name])
        if joint.name in sensors
        else _joint(robot, joint, joints[joint.name])
        for joint in robot.urdf.joints.values()
        if joint.name in sensors or joint.name in joints
    ]
    return EnhancedGraph(
        links={name: body.inertia for name, body in robot.bodies.items()},
        edges=tuple(edges),
        inertial=tuple(Leaf(imu, *robot.frame(imu)) for imu in robot.imus),
        unknown=tuple(Leaf(c.frame, c.link, c.placement) for c in contacts),
    )


def _joint(robot: Robot, joint: Joint, index: int) -> Edge:
    tail, tail_m_parent = robot.frame(joint.parent)
    head, head_m_child = robot.frame(joint.child)
    kind = "prismatic" if joint.type == "prismatic" else "revolute"
    at, beyond = tail_m_parent * joint.origin, head_m_child.inverse()
    return Edge(joint.name, kind, index, tail, head, at, beyond, joint.axis)


def _sensor(robot: Robot, joint: Joint, index: int) -> Edge:
    tail, tail_m_parent = robot.frame(joint.parent)
    head, head_m_child = robot.frame(joint.child)
    parent_m_sensor = robot.ft_placements[index]
    sensor_m_head = parent_m_sensor.inverse() * joint.origin * head_m_child.inverse()
    name, at = robot.ft_sensors[index], tail_m_parent * parent_m_sensor
    return Edge(name, "sensor", index, tail, head, at, sensor_m_head, np.zeros(3))
