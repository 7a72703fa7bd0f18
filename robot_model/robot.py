"""A robot as Wrenchbus sees it: its description checked against its URDF."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from robot_model.body_graph import RigidBody, Subtree, rigid_bodies
from robot_model.inertial import InertialSensor
from robot_model.names import did_you_mean
from robot_model.urdf import ForceTorqueElement, Urdf

if TYPE_CHECKING:
    from robot_model.surface import Surface
    from robot_model.tree import TreeModel


@dataclass(frozen=True, eq=False)
class Robot:
    """What the processes need to know about a robot; made by ``load_robot``.

    Joint vectors are in the description's order. Lengths: n joints, k force/torque
    sensors, m inertial sensors.
    """

    name: str
    source: Path  # the description file
    urdf: Urdf
    package_dirs: tuple[Path, ...]
    base_link: str
    joints: tuple[str, ...]
    parts: Mapping[str, np.ndarray]  # joint indices, by part
    ft_sensors: tuple[str, ...]
    ft_elements: tuple[ForceTorqueElement, ...]  # raw convention of each sensor
    ft_frames: tuple[str, ...]  # URDF frame of each reading
    ft_range: np.ndarray  # (k, 6) largest readings, N and N m; inf where unknown
    part_sensors: Mapping[str, np.ndarray]  # indices of force/torque sensors, by part
    imus: tuple[str, ...]  # frames; the first is the kinematic source
    imu_range: np.ndarray  # (m, 6) largest angular rate rad/s and acceleration m/s^2; or inf
    subtrees: tuple[Subtree, ...]  # 0 holds the base link; i + 1 is distal of sensor i
    bodies: Mapping[str, RigidBody]  # by main link
    supports: Mapping[str, tuple[str, ...]]  # frames, by kind of support
    soles: Mapping[str, np.ndarray]  # (c, 3) corners in the support frame, m
    home: np.ndarray  # (n,) rad
    position_lower: np.ndarray  # (n,) rad
    position_upper: np.ndarray  # (n,) rad
    velocity_limit: np.ndarray  # (n,) rad/s
    torque_limit: np.ndarray  # (n,) N m
    rotor_inertia: np.ndarray  # (n, n) kg m^2, seen by the joints
    viscous: np.ndarray  # (n,) N m s/rad
    coulomb: np.ndarray  # (n,) N m
    board_kp: np.ndarray  # (n,) N m/rad
    board_kd: np.ndarray  # (n,) N m s/rad
    inertial: Mapping[str, InertialSensor] = field(default_factory=dict)  # by name
    touchable_links: tuple[str, ...] = ()  # that a benchmark pushes; none: all with a surface

    @property
    def n(self) -> int:
        return len(self.joints)

    @cached_property
    def model_hash(self) -> str:
        """First 8 hex digits of the SHA-256 of the joint names joined by line feeds."""
        return hashlib.sha256("\n".join(self.joints).encode()).hexdigest()[:8]

    @cached_property
    def dimensions(self) -> dict[str, int]:
        """Sizes that messages name: n joints, k force/torque sensors, m inertial sensors."""
        return {"n": self.n, "k": len(self.ft_sensors), "m": len(self.imus)}

    @cached_property
    def inertial_sensors(self) -> tuple[InertialSensor, ...]:
        """What each of ``imus`` measures."""
        return tuple(self.inertial.get(name, InertialSensor(name)) for name in self.imus)

    @cached_property
    def links(self) -> tuple[str, ...]:
        """Main link of every rigid body."""
        return tuple(self.bodies)

    @cached_property
    def _body_of(self) -> dict[str, RigidBody]:
        return {link: body for body in self.bodies.values() for link in body.placements}

    @cached_property
    def _subtree_of(self) -> dict[str, int]:
        return {link: i for i, subtree in enumerate(self.subtrees) for link in subtree.frames}

    @cached_property
    def ft_placements(self) -> tuple[pin.SE3, ...]:
        """Placement of each sensor's frame in the URDF parent link of its joint."""
        return tuple(map(self._ft_placement, self.ft_elements, self.ft_frames))

    def _ft_placement(self, element: ForceTorqueElement, frame: str) -> pin.SE3:
        joint = self.urdf.joints[element.joint]
        main, main_m_frame = self.frame(frame)
        side = joint.parent if main == self.frame(joint.parent)[0] else joint.child
        side_m_frame = self.frame(side)[1].inverse() * main_m_frame
        return side_m_frame if side == joint.parent else joint.origin * side_m_frame

    @cached_property
    def mass(self) -> float:
        """Total mass, kg."""
        return sum(body.mass for body in self.bodies.values())

    def require_link(self, name: str) -> str:
        """Return ``name`` if it is a body's main link, else raise LookupError."""
        if name not in self.bodies:
            raise LookupError(f"{self.name} has no link '{name}'{did_you_mean(name, self.bodies)}")
        return name

    def frame(self, name: str) -> tuple[str, pin.SE3]:
        """Return the main link that bears a URDF frame, and link_M_frame."""
        if name not in self._body_of:
            hint = did_you_mean(name, self._body_of)
            raise LookupError(f"{self.name} has no frame '{name}'{hint}")
        body = self._body_of[name]
        return body.name, body.placements[name]

    def subtree_of(self, link: str) -> int:
        """Return the index of the sub-tree in which a link or frame lies."""
        if link not in self._subtree_of:
            hint = did_you_mean(link, self._subtree_of)
            raise LookupError(f"{self.name} has no link '{link}'{hint}")
        return self._subtree_of[link]

    @cached_property
    def tree(self) -> "TreeModel":
        """The plain model: free-flyer at the base link, no cuts, nv = 6 + n."""
        from robot_model.tree import build_tree

        return build_tree(self, self.base_link)

    def perturbed(self, seed: int, fraction: float) -> "Robot":
        """Return the robot with wrong link masses, for estimators that must bear them.

        Mass and inertia of each link are multiplied by 1 + e; e is normal with
        standard deviation ``fraction`` / 2, cut at ``fraction``.
        """
        errors = np.random.default_rng(seed).normal(0.0, fraction / 2, len(self.urdf.links))
        factors = 1.0 + np.clip(errors, -fraction, fraction)
        scaled = self.urdf.scaled(dict(zip(self.urdf.links, factors, strict=True)))
        bodies = rigid_bodies(scaled, [element.joint for element in self.ft_elements])
        return replace(self, urdf=scaled, bodies=bodies)

    def load_surface(self) -> "Surface":
        """Load the meshes and exposed surface points, from the disk cache when it is there."""
        from robot_model.surface import load_surface

        return load_surface(self)
