"""Mesh files of a robot, merged per rigid body and made light."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from robot_model.errors import DescriptionError
from robot_model.robot import Robot
from robot_model.urdf import Mesh

CLUSTER = 0.004  # m; halves the triangles of CAD meshes and moves no vertex by more than this


@dataclass(frozen=True, eq=False)
class Body:
    """The mesh of a rigid body, in the frame of its main link."""

    name: str  # main link
    links: tuple[str, ...]  # every URDF link of the body
    joint: str  # URDF joint that carries the body, "" for the root
    vertices: np.ndarray  # (V, 3) m
    triangles: np.ndarray  # (T, 3) vertex indices, counter-clockwise seen from outside

    @cached_property
    def center(self) -> np.ndarray:
        """Centre of the bounding sphere, (3,) m."""
        return (self.vertices.min(axis=0) + self.vertices.max(axis=0)) / 2

    @cached_property
    def radius(self) -> float:
        """Radius of the bounding sphere, m."""
        return float(np.linalg.norm(self.vertices - self.center, axis=1).max())


def mesh_files(robot: Robot) -> list[Path]:
    """Return every mesh file that the surface is made of, in URDF order."""
    return [find_mesh(robot, mesh.filename) for _, mesh in _meshes(robot, robot.urdf.links)]


def find_mesh(robot: Robot, filename: str) -> Path:
    """Return the path of a mesh that a URDF names (package://, file:// or a path)."""
    if filename.startswith("package://"):
        directories: Sequence[Path] = robot.package_dirs
        relative = filename.removeprefix("package://")
    else:
        directories = [robot.urdf.path.parent]
        relative = filename.removeprefix("file://")
    for directory in directories:
        if (directory / relative).is_file():
            return directory / relative
    looked = ", ".join(map(str, directories)) or "none: give urdf.package_dirs"
    raise DescriptionError(str(robot.source), [f"mesh '{filename}' not found in {looked}"])


def load_bodies(robot: Robot) -> list[Body]:
    """Read, merge and lighten the meshes of every body that has any."""
    bodies = []
    for body in robot.bodies.values():
        soups = []
        for link, mesh in _meshes(robot, body.placements):
            placement = body.placements[link] * mesh.placement
            points = read_triangles(find_mesh(robot, mesh.filename)) * mesh.scale
            soups.append(points @ placement.rotation.T + placement.translation)
        if soups:
            vertices, triangles = cluster(np.concatenate(soups), CLUSTER)
            links = tuple(body.placements)
            bodies.append(Body(body.name, links, body.joint, vertices, triangles))
    return bodies


def _meshes(robot: Robot, links: Iterable[str]) -> list[tuple[str, Mesh]]:
    """What is seen is what is touched; collision shapes are often boxes."""
    shapes = {name: robot.urdf.links[name] for name in links}
    return [(k, mesh) for k, link in shapes.items() for mesh in link.visuals or link.collisions]


def read_triangles(path: Path) -> np.ndarray:
    """Return a mesh file's triangles as corner points, (T, 3, 3), in file units."""
    if path.suffix.lower() == ".stl":
        raw = np.fromfile(path, dtype=np.uint8)
        count = int(raw[80:84].view("<u4")[0]) if len(raw) >= 84 else -1
        if len(raw) == 84 + 50 * count:
            records = raw[84:].reshape(count, 50)[:, 12:48]
            return np.ascontiguousarray(records).view("<f4").reshape(-1, 3, 3).astype(float)
    return _read_by_coal(path)


def _read_by_coal(path: Path) -> np.ndarray:
    import coal

    mesh = coal.MeshLoader().load(str(path), np.ones(3))
    corners = map(mesh.tri_indices, range(mesh.num_tris))
    indices = np.array([[corner[0], corner[1], corner[2]] for corner in corners])
    return np.array(mesh.vertices())[indices.reshape(-1, 3)]


def cluster(soup: np.ndarray, cell: float) -> tuple[np.ndarray, np.ndarray]:
    """Merge the vertices of a triangle soup (T, 3, 3) that share a grid cell.

    Returns vertices (V, 3), each the mean of its cell, and triangles (T', 3) without
    those that collapsed or that repeat another.
    """
    points = soup.reshape(-1, 3)
    keys = cell_keys(points, cell)
    _, owner, count = np.unique(keys, return_inverse=True, return_counts=True)
    sums = [np.bincount(owner, weights=axis) for axis in points.T]
    vertices = np.stack(sums, axis=1) / count[:, None]
    triangles = owner.reshape(-1, 3)
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    first = triangles.argmin(axis=1)[:, None]
    turned = np.take_along_axis(triangles, (first + np.arange(3)) % 3, axis=1)
    _, kept = np.unique(turned @ _mixing(len(vertices)), return_index=True)
    return vertices, turned[np.sort(kept)]


def _mixing(count: int) -> np.ndarray:
    return np.array([count * count, count, 1], dtype=np.int64)


def cell_keys(points: np.ndarray, cell: float) -> np.ndarray:
    """Return one integer per point (N, 3), equal for points in the same grid cell."""
    cells = np.floor(points / cell).astype(np.int64)
    cells -= cells.min(axis=0)
    spans = cells.max(axis=0) + 1
    return (cells[:, 0] * spans[1] + cells[:, 1]) * spans[2] + cells[:, 2]
