"""Where a click falls."""

import numpy as np
import pytest

from dashboard.picking import Ray, first_hit, pick

SQUARE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
HALVES = np.array([[0, 1, 2], [0, 2, 3]])
DOWN = np.array([0.0, 0.0, -1.0])


@pytest.fixture(scope="module")
def surface(robot):
    return robot.load_surface()


@pytest.mark.parametrize(
    ("start", "distance"),
    [((0.3, 0.6, 2.0), 2.0), ((0.9, 0.1, 0.5), 0.5), ((1.1, 0.5, 2.0), np.inf)],
)
def test_ray_meets_a_square_within_its_edges(start, distance):
    assert first_hit(SQUARE, HALVES, np.array(start), DOWN) == pytest.approx(distance)


def test_what_is_behind_or_seen_from_its_edge_is_not_met():
    start = np.array([0.3, 0.6, -1.0])
    assert first_hit(SQUARE, HALVES, start, DOWN) == np.inf
    assert first_hit(SQUARE, HALVES, start + [0, 0, 1], np.array([1.0, 0, 0])) == np.inf


@pytest.mark.parametrize("link", ["l_forearm", "head", "r_upper_leg"])
def test_looking_at_an_exposed_point_finds_it_and_pushes_inwards(surface, placement, link):
    body = [body.name for body in surface.bodies].index(link)
    own = np.flatnonzero(surface.body == body)
    outward = np.array([placement.vector(link, normal) for normal in surface.normals[own]])
    chosen = own[np.argmax(outward[:, 1])]  # faces +y; nothing of a standing robot is beside it
    point = placement.point(link, surface.points[chosen])
    normal = placement.vector(link, surface.normals[chosen])
    spot = pick(Ray(point + 0.05 * normal, -3.0 * normal), surface, placement)
    assert spot.link == link
    assert spot.point == pytest.approx(surface.points[chosen], abs=0.005)
    assert spot.inward @ surface.normals[chosen] < -0.7
    assert np.linalg.norm(spot.inward) == pytest.approx(1.0)


def test_nearer_body_hides_the_farther_one(surface, placement):
    left, right = (placement.point(hand, np.zeros(3)) for hand in ("l_hand", "r_hand"))
    across = right - left
    assert pick(Ray(left - 5.0 * across, across), surface, placement).link.startswith("l_")
    assert pick(Ray(right + 5.0 * across, -across), surface, placement).link.startswith("r_")


def test_click_beside_the_robot_is_told(surface, placement):
    with pytest.raises(ValueError, match="nothing of the robot is there"):
        pick(Ray(np.array([9.0, 9.0, 9.0]), np.array([1.0, 0.0, 0.0])), surface, placement)
