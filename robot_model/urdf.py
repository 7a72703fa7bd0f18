"""Reading a URDF: links with their inertia and meshes, joints, force/torque sensors.

Pinocchio's own loader merges both sides of a fixed joint into one body, so a model
that is cut at its force/torque sensors has to be built from the file itself.
"""

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pinocchio as pin

from robot_model.errors import DescriptionError

MOVING = {"revolute", "continuous", "prismatic"}


@dataclass(frozen=True, eq=False)
class Mesh:
    """A mesh file of a link; ``placement`` maps mesh to link coordinates."""

    filename: str
    scale: np.ndarray  # (3,)
    placement: pin.SE3


@dataclass(frozen=True, eq=False)
class Link:
    """A URDF link; ``inertia`` is expressed in the link's frame, None for a bare frame."""

    name: str
    inertia: pin.Inertia | None = None
    visuals: tuple[Mesh, ...] = ()
    collisions: tuple[Mesh, ...] = ()


@dataclass(frozen=True, eq=False)
class Joint:
    """A URDF joint; ``origin`` maps child to parent coordinates at zero position."""

    name: str
    type: str
    parent: str
    child: str
    origin: pin.SE3
    axis: np.ndarray  # (3,) unit vector, child axes
    lower: float = -np.inf
    upper: float = np.inf
    velocity: float = np.inf
    effort: float = np.inf
    mimic: bool = False

    @property
    def moving(self) -> bool:
        return self.type in MOVING


@dataclass(frozen=True, eq=False)
class ForceTorqueElement:
    """A URDF ``<sensor type="force_torque">``: how a driver reports its readings."""

    name: str
    joint: str
    frame: str = "child"  # parent, child or sensor: axes of the raw reading
    measure_direction: str = "child_to_parent"
    origin: pin.SE3 = field(default_factory=pin.SE3.Identity)  # sensor to child coordinates


@dataclass(frozen=True, eq=False)
class Urdf:
    """The parts of a URDF that Wrenchbus uses, by name, in file order."""

    path: Path
    links: Mapping[str, Link]
    joints: Mapping[str, Joint]
    ft_elements: Mapping[str, ForceTorqueElement]
    inertial_mounts: Mapping[str, Joint]  # of inertial sensors that are no links, by sensor

    @cached_property
    def root(self) -> str:
        """The link that is nobody's child."""
        children = {joint.child for joint in self.joints.values()}
        return next(name for name in self.links if name not in children)

    @cached_property
    def edges(self) -> Mapping[str, list[Joint]]:
        """All joints that touch a link, by link."""
        edges: dict[str, list[Joint]] = {name: [] for name in self.links}
        for joint in self.joints.values():
            edges[joint.parent].append(joint)
            edges[joint.child].append(joint)
        return edges

    def with_sensors(self, names: Iterable[str]) -> "Urdf":
        """Return a copy in which the inertial sensors named are frames, links or not."""
        mounts = [self.inertial_mounts[name] for name in names if name in self.inertial_mounts]
        links = {mount.child: Link(mount.child) for mount in mounts}
        joints = {mount.name: mount for mount in mounts}
        return replace(self, links={**self.links, **links}, joints={**self.joints, **joints})

    def scaled(self, factors: Mapping[str, float]) -> "Urdf":
        """Return a copy in which mass and inertia of the links named are multiplied."""
        links = dict(self.links)
        for name, factor in factors.items():
            inertia = links[name].inertia
            if inertia is not None:
                wrong = pin.Inertia(inertia.mass * factor, inertia.lever, inertia.inertia * factor)
                links[name] = replace(links[name], inertia=wrong)
        return replace(self, links=links)

    def locked(self, positions: Mapping[str, float]) -> "Urdf":
        """Return a copy in which the joints named are fixed at a position (rad or m)."""
        joints = dict(self.joints)
        for name, position in positions.items():
            joint = joints[name]
            origin = joint.origin * joint_motion(joint, position)
            joints[name] = replace(joint, type="fixed", origin=origin)
        return replace(self, joints=joints)


def joint_motion(joint: Joint, position: float) -> pin.SE3:
    """Return the map from child to joint coordinates at a position (rad or m)."""
    if joint.type == "prismatic":
        return pin.SE3(np.eye(3), joint.axis * position)
    return pin.SE3(pin.exp3(joint.axis * position), np.zeros(3))


def read_urdf(path: Path) -> Urdf:
    """Read a URDF file.

    Raises:
        DescriptionError: The file is absent, is not XML, or is not one tree of links.
    """
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise DescriptionError(str(path), [f"cannot read the URDF: {reason}"]) from None
    try:
        links = {link.name: link for link in map(_link, root.findall("link"))}
        joints = {joint.name: joint for joint in map(_joint, root.findall("joint"))}
        mounts = _inertial_mounts(root, links)
        urdf = Urdf(path, links, joints, _ft_elements(root), mounts)
    except KeyError as error:
        raise DescriptionError(str(path), [f"malformed URDF: no attribute {error}"]) from None
    except ValueError as error:
        raise DescriptionError(str(path), [f"malformed URDF: {error}"]) from None
    if problems := _not_a_tree(root, urdf):
        raise DescriptionError(str(path), problems)
    return urdf


def _not_a_tree(root: ElementTree.Element, urdf: Urdf) -> list[str]:
    problems = []
    for tag, kept in (("link", urdf.links), ("joint", urdf.joints)):
        if len(root.findall(tag)) != len(kept):
            problems.append(f"two URDF {tag}s have the same name")
    for joint in urdf.joints.values():
        for link in {joint.parent, joint.child} - set(urdf.links):
            problems.append(f"joint '{joint.name}' names an unknown link '{link}'")
    children = [joint.child for joint in urdf.joints.values()]
    roots = [name for name in urdf.links if name not in children]
    if len(roots) != 1 or len(set(children)) != len(children):
        problems.append(f"expected one tree of links, got the roots {roots}")
    return problems


def _vector(text: str | None, default: str = "0 0 0") -> np.ndarray:
    values = np.array((text or default).split(), dtype=float)
    if values.shape != (3,):
        raise ValueError(f"expected three numbers, got '{text}'")
    return values


def _child(element: ElementTree.Element, tag: str) -> ElementTree.Element:
    child = element.find(tag)
    if child is None:
        raise ValueError(f"<{element.tag}> '{element.get('name', '')}' has no <{tag}>")
    return child


def _placement(element: ElementTree.Element | None) -> pin.SE3:
    if element is None:
        return pin.SE3.Identity()
    rpy = _vector(element.get("rpy"))
    return pin.SE3(pin.rpy.rpyToMatrix(*rpy), _vector(element.get("xyz")))


def _link(element: ElementTree.Element) -> Link:
    inertial = element.find("inertial")
    inertia = None if inertial is None else _inertia(inertial)
    visuals = tuple(mesh for item in element.findall("visual") for mesh in _mesh(item))
    collisions = tuple(mesh for item in element.findall("collision") for mesh in _mesh(item))
    return Link(element.attrib["name"], inertia, visuals, collisions)


def _inertia(element: ElementTree.Element) -> pin.Inertia | None:
    mass = float(_child(element, "mass").attrib["value"])
    if mass == 0.0:
        return None
    moments = _child(element, "inertia").attrib
    xx, xy, xz, yy, yz, zz = (float(moments["i" + key]) for key in "xx xy xz yy yz zz".split())
    about_com = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return _placement(element.find("origin")).act(pin.Inertia(mass, np.zeros(3), about_com))


def _mesh(element: ElementTree.Element) -> list[Mesh]:
    mesh = element.find("geometry/mesh")
    if mesh is None:
        return []
    scale = _vector(mesh.get("scale"), "1 1 1")
    return [Mesh(mesh.attrib["filename"], scale, _placement(element.find("origin")))]


def _joint(element: ElementTree.Element) -> Joint:
    axis_element = element.find("axis")
    axis = _vector(None if axis_element is None else axis_element.get("xyz"), "1 0 0")
    limit = element.find("limit")
    limits = {} if limit is None else limit.attrib
    bounded = element.attrib["type"] != "continuous"
    return Joint(
        name=element.attrib["name"],
        type=element.attrib["type"],
        parent=_child(element, "parent").attrib["link"],
        child=_child(element, "child").attrib["link"],
        origin=_placement(element.find("origin")),
        axis=axis / (np.linalg.norm(axis) or 1.0),  # files write 0 0 0 on fixed joints
        lower=float(limits.get("lower", 0.0)) if bounded else -np.inf,
        upper=float(limits.get("upper", 0.0)) if bounded else np.inf,
        velocity=float(limits.get("velocity", np.inf)),
        effort=float(limits.get("effort", np.inf)),
        mimic=element.find("mimic") is not None,
    )


def _inertial_mounts(root: ElementTree.Element, links: Mapping[str, Link]) -> dict[str, Joint]:
    """Fixed joints for ``<sensor>`` elements that hang on a link and are none themselves."""
    mounts = {}
    for item in root.findall("sensor"):
        name, parent = item.attrib["name"], item.find("parent")
        on = "" if parent is None else parent.get("link", "")
        inertial = item.get("type") in ("accelerometer", "gyroscope", "imu")
        if inertial and on in links and name not in links:
            origin = _placement(item.find("origin"))
            mounts[name] = Joint(f"{name}_mount", "fixed", on, name, origin, np.zeros(3))
    return mounts


def _ft_elements(root: ElementTree.Element) -> dict[str, ForceTorqueElement]:
    """Gazebo's nested copies are read first, so that a top-level element replaces them."""
    found: dict[str, ForceTorqueElement] = {}
    nested = [
        (item, group.get("reference"))
        for group in root.findall("gazebo")
        for item in group.findall("sensor")
    ]
    for item, reference in nested + [(item, None) for item in root.findall("sensor")]:
        parent = item.find("parent")
        joint = parent.get("joint") if parent is not None else reference
        if item.get("type") == "force_torque" and joint:
            found[item.attrib["name"]] = _ft_element(item, joint)
    return found


def _ft_element(item: ElementTree.Element, joint: str) -> ForceTorqueElement:
    return ForceTorqueElement(
        name=item.attrib["name"],
        joint=joint,
        frame=(item.findtext("force_torque/frame") or "child").strip(),
        measure_direction=(
            item.findtext("force_torque/measure_direction") or "child_to_parent"
        ).strip(),
        origin=_placement(item.find("origin")),
    )
