import numpy as np
import pytest

from dashboard.push import DIRECTIONS, push_point


@pytest.fixture(scope="session")
def surface(robot):
    return robot.load_surface()


@pytest.mark.parametrize("direction", DIRECTIONS.values())
@pytest.mark.parametrize("link", ["l_forearm", "chest", "r_lower_leg", "head"])
def test_push_presses_onto_the_surface(surface, link, direction):
    body = [body.name for body in surface.bodies].index(link)
    point = push_point(surface, body, np.array(direction))
    own = surface.body == body
    index = np.argmin(np.linalg.norm(surface.points[own] - point, axis=1))
    assert surface.points[own][index] == pytest.approx(point)
    assert surface.normals[own][index] @ direction < -0.5


def test_link_without_exposed_surface_cannot_be_pushed(surface):
    covered = set(range(len(surface.bodies))) - set(surface.body.tolist())
    if not covered:
        pytest.fail("expected a covered body on iCub; choose another example")
    with pytest.raises(ValueError, match="no exposed surface"):
        push_point(surface, covered.pop(), np.array([1.0, 0.0, 0.0]))
