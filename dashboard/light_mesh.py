"""Meshes light enough for a browser that draws in software."""

import numpy as np

Array = np.ndarray


def lighten(vertices: Array, triangles: Array, cell: float) -> tuple[Array, Array]:
    """Return a mesh in which the vertices of each cubic cell are one, at their mean.

    No vertex moves farther than the cell's diagonal; triangles that have collapsed
    or come twice are gone.

    Args:
        vertices: (V, 3) [m].
        triangles: Vertex indices, (T, 3).
        cell: Edge of the cells [m].

    Source:
        Rossignac, Borrel, "Multi-resolution 3D approximations for rendering complex
        scenes", 1993.
    """
    if not len(vertices):
        return vertices, triangles
    cells = np.floor((vertices - vertices.min(axis=0)) / cell).astype(np.int64)
    numbers = np.ravel_multi_index(tuple(cells.T), tuple(cells.max(axis=0) + 1))
    _, member, count = np.unique(numbers, return_inverse=True, return_counts=True)
    sums = [np.bincount(member, weights=axis) for axis in vertices.T]
    means = np.stack(sums, axis=1) / count[:, None]
    moved = member[triangles]
    a, b, c = moved.T
    moved = moved[(a != b) & (b != c) & (c != a)]
    keys = np.sort(moved, axis=1) @ np.array([len(means) ** 2, len(means), 1])  # one per triangle
    _, first = np.unique(keys, return_index=True)
    return means, moved[np.sort(first)]
