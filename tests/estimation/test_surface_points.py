"""Which of the stored points of the surface a push is held against."""

import numpy as np
import pytest

from estimation.contact.surface_points import SPACING, SurfacePoints
from robot_model import load_robot
from tests.estimation.touched_rows import TouchedRows

EDGE = "l_upper_arm"


@pytest.fixture(scope="module")
def touched() -> TouchedRows:
    return TouchedRows(load_robot("icub"))


@pytest.fixture(scope="module")
def surface(touched: TouchedRows) -> SurfacePoints:
    return SurfacePoints(touched.robot)


def test_near_an_edge_a_push_enters_by_the_side_that_it_presses_on(surface: SurfacePoints) -> None:
    points, normals = surface.points[EDGE], surface.normals[EDGE]
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    pairs = np.argwhere((apart < SPACING) & (normals @ normals.T < 0.2))
    assert len(pairs)
    for one, other in pairs[:20].tolist():
        place = points[[one]] + 1e-4 * (points[[other]] - points[[one]])
        force = -10.0 * normals[[other]]
        assert np.vecdot(-force, surface.entered([EDGE], place, force).normal)[0] > 7.0
        force = -10.0 * normals[[one]]
        np.testing.assert_array_equal(
            surface.entered([EDGE], place, force).point[0], points[one]
        )  # the nearest


def test_a_light_push_is_not_drawn_to_a_stored_point(touched: TouchedRows) -> None:
    index = int(touched.points_of("l_forearm")[40])
    normal, stored = touched.surface.normals[index], touched.surface.points[index]
    along = np.cross(normal, [0.0, 0.0, 1.0])
    place = stored + 0.004 * along / np.linalg.norm(along)
    locator = touched.locator()
    locator.add(touched.at("l_forearm", place, -0.5 * normal), 0.004)
    limb = touched.robot.subtree_of("l_forearm")
    best = locator.search(locator.look(touched.frame, [limb], [], 0.0, 0)).hypotheses[0]
    assert best.links[0] == "l_forearm"
    assert np.linalg.norm(best.point - place) < 4e-4
