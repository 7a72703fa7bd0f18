import numpy as np
import pytest

from dashboard.light_mesh import lighten

CELL = 0.008


@pytest.fixture(scope="module")
def forearm(robot):
    return next(body for body in robot.load_surface().bodies if body.name == "l_forearm")


def test_light_mesh_has_fewer_triangles_in_the_same_place(forearm):
    vertices, triangles = lighten(forearm.vertices, forearm.triangles, CELL)
    assert len(triangles) < 0.8 * len(forearm.triangles)
    assert vertices.min(axis=0) == pytest.approx(forearm.vertices.min(axis=0), abs=CELL)
    assert vertices.max(axis=0) == pytest.approx(forearm.vertices.max(axis=0), abs=CELL)


def test_light_mesh_has_no_collapsed_and_no_double_triangles(forearm):
    _, triangles = lighten(forearm.vertices, forearm.triangles, CELL)
    assert all(len(set(triangle)) == 3 for triangle in triangles.tolist())
    assert len({frozenset(triangle) for triangle in triangles.tolist()}) == len(triangles)


def test_triangles_keep_their_orientation():
    vertices = np.array([[0.0, 0, 0], [1.0, 0, 0], [0.0, 1, 0], [0.001, 0, 0]])
    _, triangles = lighten(vertices, np.array([[0, 1, 2], [0, 3, 2]]), CELL)
    corners = lighten(vertices, np.array([[0, 1, 2]]), CELL)[0][triangles[0]]
    assert np.cross(corners[1] - corners[0], corners[2] - corners[0])[2] > 0.0
    assert len(triangles) == 1


def test_empty_mesh_stays_empty():
    vertices, triangles = lighten(np.zeros((0, 3)), np.zeros((0, 3), dtype=int), CELL)
    assert len(vertices) == len(triangles) == 0
