"""Rigid bodies and sub-trees of a URDF.

Links joined by fixed joints are one rigid body, except across a force/torque
sensor: its two sides are bodies of their own and lie in different sub-trees.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import pinocchio as pin

from robot_model.urdf import Joint, Urdf


@dataclass(frozen=True, eq=False)
class RigidBody:
    """Links that never move against each other, named after the main one.

    ``placements[frame]`` maps the frame's coordinates to the main link's;
    ``joint`` is the URDF joint between the body and its parent ("" for the root).
    """

    name: str
    joint: str
    placements: Mapping[str, pin.SE3]
    inertia: pin.Inertia  # of all its links, in the main link's frame

    @property
    def mass(self) -> float:
        """Mass, kg."""
        return self.inertia.mass


@dataclass(frozen=True, eq=False)
class Subtree:
    """What lies between force/torque sensors.

    ``ft_in`` is the index of the sensor through which the sub-tree hangs (-1 for the
    root), ``ft_out`` those of the sensors on which other sub-trees hang.
    """

    name: str
    default_frame: str
    default_link: str
    links: tuple[str, ...]  # main links of its bodies
    frames: frozenset[str]  # every URDF link
    ft_in: int
    ft_out: tuple[int, ...]


def rigid_bodies(urdf: Urdf, ft_joints: Collection[str]) -> dict[str, RigidBody]:
    """Return the bodies in depth-first order from the root, by main link."""
    bodies = {}
    for link, joint in _body_starts(urdf, ft_joints):
        placements = _fixed_cluster(urdf, link, ft_joints)
        main = next((name for name in placements if _bears_body(urdf, name)), link)
        main_m_first = placements[main].inverse()
        relative = {name: main_m_first * placement for name, placement in placements.items()}
        relative[main] = pin.SE3.Identity()
        bodies[main] = RigidBody(main, joint, relative, _inertia(urdf, relative))
    return bodies


def _inertia(urdf: Urdf, placements: Mapping[str, pin.SE3]) -> pin.Inertia:
    total = pin.Inertia.Zero()
    for name, placement in placements.items():
        inertia = urdf.links[name].inertia
        if inertia is not None:
            total += placement.act(inertia)
    return total


def _bears_body(urdf: Urdf, name: str) -> bool:
    link = urdf.links[name]
    return link.inertia is not None or bool(link.collisions or link.visuals)


def _children(urdf: Urdf, link: str) -> list[Joint]:
    return [joint for joint in urdf.edges[link] if joint.parent == link]


def _body_starts(urdf: Urdf, ft_joints: Collection[str]) -> list[tuple[str, str]]:
    """First link of each body, and the joint that leads to it, depth first."""
    starts = [(urdf.root, "")]
    stack = _children(urdf, urdf.root)[::-1]
    while stack:
        joint = stack.pop()
        stack += _children(urdf, joint.child)[::-1]
        if joint.moving or joint.name in ft_joints:
            starts.append((joint.child, joint.name))
    return starts


def _fixed_cluster(urdf: Urdf, first: str, ft_joints: Collection[str]) -> dict[str, pin.SE3]:
    placements = {first: pin.SE3.Identity()}
    stack = [first]
    while stack:
        link = stack.pop(0)
        for joint in _children(urdf, link):
            if not joint.moving and joint.name not in ft_joints:
                placements[joint.child] = placements[link] * joint.origin
                stack.append(joint.child)
    return placements


def subtree_frames(urdf: Urdf, ft_joints: Collection[str]) -> dict[str, frozenset[str]]:
    """Return the URDF links of each sub-tree, by the joint it hangs on ("" for the root)."""
    starts = {"": urdf.root} | {name: urdf.joints[name].child for name in ft_joints}
    return {name: frozenset(_reach(urdf, link, ft_joints)) for name, link in starts.items()}


def _reach(urdf: Urdf, first: str, ft_joints: Collection[str]) -> list[str]:
    reached, stack = [], [first]
    while stack:
        link = stack.pop()
        reached.append(link)
        stack += [j.child for j in _children(urdf, link) if j.name not in ft_joints]
    return reached
