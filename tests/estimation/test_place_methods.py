"""The three ways to find a touch, on the same touches."""

import numpy as np
import pytest

from estimation.contact.localiser import METHODS, Localiser
from tests.estimation.touched_rows import TouchedRows, Watch

LINKS = ("chest", "head", "l_forearm", "r_upper_leg")
PER_LINK = 6
TOLERANCE = {"surface": 0.001, "line": 0.004, "particle": 0.008}  # m, median on exact rows


def places(touched: TouchedRows) -> list[int]:
    chosen = [touched.points_of(link) for link in LINKS]
    return [int(i) for points in chosen for i in points[:: len(points) // PER_LINK][:PER_LINK]]


@pytest.mark.parametrize("method", METHODS)
def test_each_method_finds_exact_touches(touched: TouchedRows, method: str) -> None:
    errors, right = [], 0
    for index in places(touched):
        link = touched.surface.link_of(index)
        watch = Watch(touched, touched.robot.subtree_of(link), method)
        found = [watch.look(touched.push(index, 15.0)) for _ in range(4)][-1]
        best = found.hypotheses[0]
        right += link in best.links
        true = (link, touched.surface.points[index])
        errors.append(touched.between(true, (best.links[0], best.point)))
        assert found.none_probability < 0.1
        assert 0.0 <= best.probability <= 1.0
        assert np.linalg.eigvalsh(best.covariance).min() >= -1e-9
    assert right >= len(errors) - 2
    assert np.median(errors) < TOLERANCE[method]


@pytest.mark.parametrize("method", METHODS)
def test_no_method_explains_a_pure_moment(touched: TouchedRows, method: str) -> None:
    rows = touched.rows
    moment = np.array([0.0, 0.0, 0.1, 0.0, 0.0, 2.0])
    values = (rows.layout.rows_of("l_forearm")[:, None] * rows.jacobian) @ moment
    limb = touched.robot.subtree_of("l_forearm")
    found = Localiser(rows, method).locate(values, touched.covariance, limb)
    assert found.none_probability > 0.9


def test_equal_touches_give_equal_answers(touched: TouchedRows) -> None:
    index = places(touched)[0]
    limb = touched.robot.subtree_of("chest")
    rows = touched.push(index, 15.0)
    touched.locator("surface")  # a method begins anew when it is chosen
    first = Watch(touched, limb, "particle").look(rows)
    touched.locator("surface")
    second = Watch(touched, limb, "particle").look(rows)
    np.testing.assert_array_equal(first.hypotheses[0].point, second.hypotheses[0].point)


def test_an_unknown_method_is_refused_with_those_that_exist(touched: TouchedRows) -> None:
    with pytest.raises(ValueError, match="one of surface, line, particle, got 'guess'"):
        Localiser(touched.rows, "guess")


def test_the_method_can_be_changed_while_the_robot_is_touched(touched: TouchedRows) -> None:
    index = places(touched)[0]
    watch = Watch(touched, touched.robot.subtree_of("chest"))
    rows = touched.push(index, 15.0)
    before = watch.look(rows).hypotheses[0]
    watch.locator.configure(1e-3, "line")
    after = watch.look(rows).hypotheses[0]
    assert before.links[0] == after.links[0] == "chest"
    assert not np.array_equal(before.point, after.point)
