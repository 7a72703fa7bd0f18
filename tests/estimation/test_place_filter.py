"""Touches that are held, that slide, that change their place, and that are two."""

import numpy as np
import pytest

from estimation.contact.link_fits import LinkFits
from estimation.contact.localisation import Localisation
from estimation.contact.place_filter import LOOKS, PlaceFilter
from tests.estimation.touched_rows import TouchedRows, Watch

Array = np.ndarray
HELD = 12  # looks, 0.6 s


def true_probability(found: Localisation, link: str) -> float:
    return sum(h.probability for h in found.hypotheses if h.links[0] == link)


def along(touched: TouchedRows, link: str, length: float) -> list[int]:
    """Surface points of a link from one end of its long side for so many metres."""
    mine = touched.points_of(link)
    points, normals = touched.surface.points[mine], touched.surface.normals[mine]
    axis = np.argmax(np.ptp(points, axis=0))
    side = normals[len(mine) // 2]
    facing = mine[normals @ side > 0.8]
    height = touched.surface.points[facing][:, axis]
    order = facing[np.argsort(height)]
    start = np.quantile(height, 0.2)
    reached = touched.surface.points[order][:, axis]
    return order[(reached >= start) & (reached <= start + length)].tolist()


def test_a_held_push_is_known_better_with_time(touched: TouchedRows) -> None:
    errors, sure = [], []
    for link in ("l_forearm", "r_upper_leg", "chest", "head"):
        for index in touched.points_of(link)[20::90][:3].tolist():
            watch = Watch(touched, touched.robot.subtree_of(link))
            rows, truth = touched.push(index, 8.0), touched.surface.points[index]
            found = [watch.look(rows + touched.noise()) for _ in range(HELD)]
            best = [one.hypotheses[0] for one in found]
            away = [touched.between((link, truth), (h.links[0], h.point)) for h in best]
            errors.append((away[0], away[-1]))
            sure.append([true_probability(one, link) for one in (found[0], found[-1])])
    first, last = np.mean(errors, axis=0)
    assert last < 0.7 * first
    assert np.mean(sure, axis=0)[1] > np.mean(sure, axis=0)[0]


def test_a_slide_of_ten_centimetres_in_a_second_is_followed(touched: TouchedRows) -> None:
    link = "l_upper_leg"
    path = along(touched, link, 0.1)
    watch = Watch(touched, touched.robot.subtree_of(link))
    places = touched.surface.points[path]
    axis = np.argmax(np.ptp(places, axis=0))
    errors = []
    for moved in np.linspace(0.0, 1.0, 21):
        goal = places[0, axis] + moved * np.ptp(places[:, axis])
        index = path[int(np.argmin(abs(places[:, axis] - goal)))]
        best = watch.look(touched.push(index, 10.0) + touched.noise(0.5)).hypotheses[0]
        errors.append(touched.between((link, touched.surface.points[index]), (link, best.point)))
        assert best.links[0] == link
    assert np.ptp(places[:, axis]) > 0.08
    assert np.median(errors) < 0.02
    assert max(errors) < 0.06


@pytest.mark.parametrize(("one", "other"), [("l_forearm", "l_hand"), ("chest", "root_link")])
def test_a_touch_that_goes_to_another_link_is_followed_within_0_3_s(
    touched: TouchedRows, one: str, other: str
) -> None:
    watch = Watch(touched, touched.robot.subtree_of(one))
    first, second = (int(touched.points_of(link)[40]) for link in (one, other))
    for _ in range(HELD):
        found = watch.look(touched.push(first, 10.0) + touched.noise())
    assert found.hypotheses[0].links[0] == one
    for _ in range(6):
        found = watch.look(touched.push(second, 10.0) + touched.noise())
    assert found.hypotheses[0].links[0] == other
    assert found.hypotheses[0].probability > 0.5


def test_two_pushes_on_one_limb_are_none_that_is_known(touched: TouchedRows) -> None:
    doubts = []
    for one, other in (("l_forearm", "l_upper_arm"), ("r_hand", "r_upper_arm")):
        pairs = zip(touched.points_of(one)[::60], touched.points_of(other)[30::60], strict=False)
        for first, second in pairs:
            watch = Watch(touched, touched.robot.subtree_of(one))
            rows = touched.push(int(first), 12.0) + touched.push(int(second), 12.0)
            doubts.append(watch.look(rows + touched.noise()).none_probability)
    assert len(doubts) > 8
    assert np.mean(np.array(doubts) > 0.9) >= 0.8


def test_a_touch_that_begins_anew_knows_nothing_of_the_last(touched: TouchedRows) -> None:
    watch = Watch(touched, touched.robot.subtree_of("l_forearm"))
    first, second = (int(touched.points_of(link)[40]) for link in ("l_forearm", "l_hand"))
    for _ in range(HELD):
        watch.look(touched.push(first, 10.0))
    watch.locator.keep(())
    again = watch.look(touched.push(second, 10.0)).hypotheses[0]
    fresh = Watch(touched, touched.robot.subtree_of("l_forearm"))
    expected = fresh.look(touched.push(second, 10.0)).hypotheses[0]
    assert again.links == expected.links
    assert again.probability == pytest.approx(expected.probability, abs=1e-3)
    np.testing.assert_allclose(again.point, expected.point, atol=1e-4)


def fits(weights: dict[str, float], point: Array) -> LinkFits:
    k = len(weights)
    return LinkFits(
        links=list(weights),
        weight=np.array(list(weights.values())),
        point=np.tile(point, (k, 1)),
        force=np.ones((k, 3)),
        covariance=np.tile(1e-6 * np.eye(6), (k, 1, 1)),
        misfit=0.0,
        places=lambda: pytest.fail("nobody looks"),
    )


def test_many_looks_are_worth_little_more_than_one_however_long_the_touch_is_held() -> None:
    filter_ = PlaceFilter(["hand", "forearm"])
    look = fits({"hand": 0.0, "forearm": -1.0}, np.zeros(3))
    ahead = [-filter_.add(look, 0.05).weight[1] for _ in range(100)]
    assert ahead[0] == pytest.approx(1.0)
    assert np.all(np.diff(ahead) >= 0.0)
    assert ahead[-1] == pytest.approx(LOOKS, abs=1e-6)


def test_points_are_averaged_while_they_scatter_and_followed_when_they_move_on() -> None:
    random = np.random.default_rng(3)
    held, sliding = PlaceFilter(["hand"]), PlaceFilter(["hand"])
    scatter = 0.003 * random.normal(size=(200, 3))
    steady = [held.add(fits({"hand": 0.0}, p), 0.05).point[0] for p in scatter]
    assert np.std(steady[20:]) < 0.65 * np.std(scatter)
    path = np.outer(np.arange(40), [0.005, 0.0, 0.0])
    seen = [sliding.add(fits({"hand": 0.0}, p), 0.05).point[0] for p in path]
    assert np.abs(np.array(seen) - path)[20:].max() < 0.007
