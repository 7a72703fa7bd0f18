"""Where a click on the robot falls on its body."""

from typing import NamedTuple

import numpy as np

from robot_model.meshes import Body
from robot_model.surface import Surface

from .placement import Placement

Array = np.ndarray

SMOOTH = 12  # exposed points whose normals are averaged: one alone may lie in a groove


class Ray(NamedTuple):
    """A line of sight, world."""

    origin: Array  # (3,) [m]
    direction: Array  # (3,)


class Spot(NamedTuple):
    """A place on a body."""

    link: str
    point: Array  # (3,) [m], link frame
    inward: Array  # (3,) unit vector into the body, link axes


def pick(ray: Ray, surface: Surface, placement: Placement) -> Spot:
    """Return the place at which a line of sight first meets the robot.

    Raises:
        ValueError: It meets nothing, or a body of which nothing is exposed.
    """
    sight = Ray(ray.origin, ray.direction / np.linalg.norm(ray.direction))
    seen = [_in_frame(placement, body.name, sight) for body in surface.bodies]
    distances = list(map(_distance, surface.bodies, seen))
    body = int(np.argmin(distances))
    if not np.isfinite(distances[body]):
        raise ValueError("nothing of the robot is there")
    point = seen[body].origin + distances[body] * seen[body].direction
    inward = _inward(surface, body, point, seen[body].direction)
    return Spot(surface.bodies[body].name, point, inward)


def first_hit(vertices: Array, triangles: Array, origin: Array, direction: Array) -> float:
    """Return how far along a ray the first triangle is, from either side; infinite without one.

    Args:
        vertices: (V, 3) [m].
        triangles: Vertex indices, (T, 3).
        origin: (3,) [m].
        direction: (3,).

    Returns:
        Distance in lengths of ``direction``, positive.

    Source:
        Moeller, Trumbore, "Fast, minimum storage ray-triangle intersection", 1997.
    """
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    ab, ac, along = b - a, c - a, np.cross(direction, c - a)
    volume = np.einsum("ij,ij->i", ab, along)
    with np.errstate(divide="ignore", invalid="ignore"):  # a triangle that is seen from its edge
        scale = 1.0 / volume
        offset = origin - a
        across = np.cross(offset, ab)
        u = scale * np.einsum("ij,ij->i", offset, along)
        v = scale * (across @ direction)
        distance = scale * np.einsum("ij,ij->i", ac, across)
        hit = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (distance > 0.0) & np.isfinite(scale)
    return float(distance[hit].min(initial=np.inf))


def _in_frame(placement: Placement, link: str, ray: Ray) -> Ray:
    origin = placement.inverse_point(link, ray.origin)
    return Ray(origin, placement.inverse_vector(link, ray.direction))


def _distance(body: Body, ray: Ray) -> float:
    """Return how far away the body is; a ray that misses its sphere needs no triangles."""
    offset = body.center - ray.origin
    beside = np.linalg.norm(offset - (offset @ ray.direction) * ray.direction)
    if beside > body.radius:
        return np.inf
    return first_hit(body.vertices, body.triangles, ray.origin, ray.direction)


def _inward(surface: Surface, body: int, point: Array, sight: Array) -> Array:
    """Return the inward normal, smoothed over the exposed points around; away from who looks."""
    own = np.flatnonzero(surface.body == body)
    if not len(own):
        raise ValueError(f"link {surface.bodies[body].name} has no exposed surface to push")
    near = own[np.argsort(np.linalg.norm(surface.points[own] - point, axis=1))[:SMOOTH]]
    facing = near[surface.normals[near] @ sight < 0.0]
    normal = surface.normals[facing].mean(axis=0) if len(facing) else -sight
    return -normal / np.linalg.norm(normal)
