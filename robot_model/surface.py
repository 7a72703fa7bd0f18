"""The surface of a robot: meshes per body, and the points where it can be touched.

``python -m robot_model.surface ROBOT`` fills the disk cache.
"""

import hashlib
import sys
from collections.abc import Callable
from functools import cached_property

import numpy as np

from robot_model.cache import Arrays, cached
from robot_model.exposure import exposed_points
from robot_model.load import load_robot
from robot_model.meshes import Body, load_bodies, mesh_files
from robot_model.robot import Robot

VERSION = "1"  # raise it when meshes or points come out different


class Surface:
    """Meshes of the bodies, at once, and exposed points, at first use.

    The first use on a machine takes some seconds for the points; a page that only
    draws never pays for them.
    """

    def __init__(self, robot: Robot, key: str):
        self._robot = robot
        self._key = key
        self.bodies: tuple[Body, ...] = _unpack(robot, self._cached("meshes", self._pack_meshes))

    def _cached(self, kind: str, build: Callable[[], Arrays]) -> Arrays:
        return cached(f"{self._robot.name}-{kind}-{self._key}", build)

    def _pack_meshes(self) -> Arrays:
        return _pack(load_bodies(self._robot))

    def _pack_points(self) -> Arrays:
        points, normals, body = exposed_points(self._robot, self.bodies)
        return {"points": points, "normals": normals, "body": body}

    @cached_property
    def _exposed(self) -> Arrays:
        return self._cached("points", self._pack_points)

    @property
    def points(self) -> np.ndarray:
        """Exposed points about 10 mm apart, (P, 3) m, in the frame of their link."""
        return self._exposed["points"]

    @property
    def normals(self) -> np.ndarray:
        """Outward unit normals at the points, (P, 3), in the axes of their link."""
        return self._exposed["normals"]

    @property
    def body(self) -> np.ndarray:
        """Index into ``bodies`` of each point, (P,)."""
        return self._exposed["body"]

    def link_of(self, point: int) -> str:
        """Return the link on which the point of this index lies."""
        return self.bodies[self.body[point]].name


def load_surface(robot: Robot) -> Surface:
    """Load a robot's surface, from the disk cache when nothing it depends on has changed."""
    return Surface(robot, _content_key(robot))


def _content_key(robot: Robot) -> str:
    digest = hashlib.sha256(VERSION.encode())
    for file in (robot.source, robot.urdf.path, *mesh_files(robot)):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def _pack(bodies: list[Body]) -> Arrays:
    """Single precision rounds a metre to 0.1 micrometre, and halves what is read."""
    return {
        "name": np.array([body.name for body in bodies], dtype=np.str_),
        "vertices": np.concatenate([b.vertices for b in bodies] or [np.zeros((0, 3))]).astype("f4"),
        "triangles": np.concatenate(
            [b.triangles for b in bodies] or [np.zeros((0, 3), dtype=int)]
        ).astype("i4"),
        "vertex_count": np.array([len(b.vertices) for b in bodies], dtype=int),
        "triangle_count": np.array([len(b.triangles) for b in bodies], dtype=int),
    }


def _unpack(robot: Robot, arrays: Arrays) -> tuple[Body, ...]:
    vertices = _split(arrays["vertices"].astype(float), arrays["vertex_count"])
    triangles = _split(arrays["triangles"], arrays["triangle_count"])
    bodies = [robot.bodies[str(name)] for name in arrays["name"]]
    return tuple(
        Body(body.name, tuple(body.placements), body.joint, v, t)
        for body, v, t in zip(bodies, vertices, triangles, strict=True)
    )


def _split(rows: np.ndarray, counts: np.ndarray) -> list[np.ndarray]:
    return np.split(rows, np.cumsum(counts)[:-1]) if len(counts) else []


def main() -> None:
    surface = load_surface(load_robot(*sys.argv[1:2]))
    print(f"{len(surface.bodies)} bodies, {len(surface.points)} exposed points")


if __name__ == "__main__":
    main()
