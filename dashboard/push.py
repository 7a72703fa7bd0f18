"""Where and how a push of the page acts on a link."""

from typing import Any

import numpy as np

from robot_model.surface import Surface

Array = np.ndarray

DIRECTIONS = {
    "+x": (1.0, 0.0, 0.0),
    "-x": (-1.0, 0.0, 0.0),
    "+y": (0.0, 1.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "+z": (0.0, 0.0, 1.0),
    "-z": (0.0, 0.0, -1.0),
}  # of the force, world axes


def push_point(surface: Surface, body: int, direction: Array) -> Array:
    """Return a point of the body's exposed surface that a push can press, (3,) [m], link frame.

    The point faces the push, and of such points it is the one nearest the line through
    the middle of the exposed surface.

    Args:
        surface: The robot's surface.
        body: Index of the body.
        direction: Unit vector of the force, (3,), link axes.

    Raises:
        ValueError: Nothing of the body is exposed.
    """
    own = np.flatnonzero(surface.body == body)
    if not len(own):
        raise ValueError(f"link {surface.bodies[body].name} has no exposed surface to push")
    points, normals = surface.points[own], surface.normals[own]
    offset = points - points.mean(axis=0)
    beside = np.linalg.norm(offset - np.outer(offset @ direction, direction), axis=1)
    size = float(np.ptp(points, axis=0).max()) or 1.0
    return points[np.argmin(beside / size + 1.0 + normals @ direction)]


def push_request(link: str, point: Array, force: Array, frame: str) -> dict[str, Any]:
    """Return the arguments of the plant's verb ``push``, for a force at full strength.

    Args:
        link: What is pushed.
        point: Where, (3,) [m], link frame.
        force: (3,) [N], in the axes of ``frame``.
        frame: ``link`` or ``world``.
    """
    place = {"link": link, "point": point.tolist()}
    return {**place, "force": force.tolist(), "frame": frame, "profile": "hold"}
