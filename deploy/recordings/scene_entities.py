"""Parts of Foxglove scenes, as the maps that its JSON schemas describe."""

from typing import Any

import numpy as np
import pinocchio as pin

from dashboard.forces import Force
from robot_model import Robot
from robot_model.errors import DescriptionError
from robot_model.meshes import cluster, load_bodies

Array = np.ndarray
Map = dict[str, Any]

CELL = 0.015  # m; some 20 000 triangles for iCub
GREY, ORANGE, BLUE, RED = (
    dict(zip("rgba", rgba, strict=True))
    for rgba in ((0.7, 0.7, 0.72, 1), (1, 0.55, 0, 1), (0.2, 0.5, 1, 1), (0.9, 0.1, 0.1, 1))
)
IDENTITY = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
PRIMITIVES = ("arrows cubes spheres cylinders lines triangles texts models").split()
DIAMETER = 0.012  # m


def timestamp(time: int) -> Map:
    """Return a time [ns] as Foxglove writes it."""
    return {"sec": time // 1_000_000_000, "nsec": time % 1_000_000_000}


def transform(time: int, parent: str, child: str, pose: Array) -> Map:
    """Return a FrameTransform.

    Args:
        time: [ns].
        parent: Frame in which the pose is given.
        child: Frame that stands there.
        pose: Position [m] and quaternion xyzw, (7,).
    """
    return {
        "timestamp": timestamp(time),
        "parent_frame_id": parent,
        "child_frame_id": child,
        "translation": _xyz(pose[:3]),
        "rotation": dict(zip("xyzw", pose[3:].tolist(), strict=True)),
    }


def entity(time: int, frame: str, name: str, lifetime: int = 0, **primitives: list[Map]) -> Map:
    """Return a SceneEntity that moves with its frame; ``lifetime`` [ns], 0 for ever."""
    return {
        "timestamp": timestamp(time),
        "frame_id": frame,
        "id": name,
        "lifetime": timestamp(lifetime),
        "frame_locked": True,
        "metadata": [],
        **{kind: primitives.get(kind, []) for kind in PRIMITIVES},
    }


def arrow(force: Force, scale: float, color: Map) -> Map:
    """Return an arrow whose tip is where the force acts, ``scale`` [m/N] long."""
    length = scale * float(np.linalg.norm(force.force))
    head = min(0.04, 0.4 * length)
    axis = pin.Quaternion.FromTwoVectors(np.array([1.0, 0.0, 0.0]), force.force)
    orientation = dict(zip("xyzw", axis.coeffs().tolist(), strict=True))
    return {
        "pose": {"position": _xyz(force.point - scale * force.force), "orientation": orientation},
        "shaft_length": length - head,
        "shaft_diameter": DIAMETER,
        "head_length": head,
        "head_diameter": 2.0 * DIAMETER,
        "color": color,
    }


def robot_entities(time: int, robot: Robot) -> list[Map]:
    """Return the robot's shape, one entity per body in the body's frame.

    Where its meshes are not on this machine: a ball at every joint.
    """
    try:
        bodies = load_bodies(robot)
    except DescriptionError:
        bodies = []
    if not bodies:
        return [entity(time, link, link, spheres=[_ball()]) for link in robot.links]
    return [
        entity(time, body.name, body.name, triangles=[_mesh(body.vertices, body.triangles)])
        for body in bodies
    ]


def _mesh(vertices: Array, triangles: Array) -> Map:
    vertices, triangles = cluster(vertices[triangles], CELL)
    return {
        "pose": {"position": _xyz(np.zeros(3)), "orientation": IDENTITY},
        "points": [_xyz(vertex) for vertex in vertices.round(4)],
        "color": GREY,
        "colors": [],
        "indices": triangles.ravel().tolist(),
    }


def _ball() -> Map:
    pose = {"position": _xyz(np.zeros(3)), "orientation": IDENTITY}
    return {"pose": pose, "size": {"x": 0.05, "y": 0.05, "z": 0.05}, "color": GREY}


def _xyz(vector: Array) -> Map:
    return dict(zip("xyz", vector.tolist(), strict=True))
