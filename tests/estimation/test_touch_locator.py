"""How the rows of a touch are smoothed before its place is looked for."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from estimation.contact.contact_rows import ContactRows
from estimation.contact.row_covariance import RowNoise
from estimation.contact.touch_locator import TouchLocator
from robot_model import load_robot
from tests.estimation.touched_rows import TouchedRows

Array = np.ndarray
Statistic = Callable[[Array], Array]
PERIOD = 0.004  # s


@pytest.fixture(scope="module")
def touched() -> TouchedRows:
    return TouchedRows(load_robot("icub"))


@pytest.fixture
def locator(touched: TouchedRows) -> TouchLocator:
    return TouchLocator(touched.rows, RowNoise(), 0.06, "surface")


@pytest.fixture(scope="module")
def statistic(touched: TouchedRows) -> Statistic:
    matrices = touched.covariance.of_wrenches()
    matrices[touched.rows.removed.subtrees] = np.eye(6)
    information = np.linalg.inv(matrices)

    def norm(rows: np.ndarray) -> np.ndarray:
        wrenches = touched.rows.wrenches(rows)
        return np.sqrt(np.vecdot(wrenches, np.matvec(information, wrenches)))

    return norm


def add(locator: TouchLocator, rows: Array, statistic: Statistic) -> None:
    locator.add(rows, PERIOD, float(statistic(locator.change(rows)).max()))


def test_a_sudden_push_has_its_force_after_a_few_samples(
    touched: TouchedRows, locator: TouchLocator, statistic: Statistic
) -> None:
    index = int(touched.points_of("l_forearm")[40])
    limb = touched.robot.subtree_of("l_forearm")
    add(locator, np.zeros(touched.rows.layout.model.nv), statistic)
    for _ in range(5):
        add(locator, touched.push(index, 15.0), statistic)
    best = locator.search(locator.look(touched.frame, [limb], [], 0.0, 0)).hypotheses[0]
    assert np.linalg.norm(best.force) == pytest.approx(15.0, abs=0.5)


def test_noise_is_smoothed_although_sudden_changes_are_followed(
    touched: TouchedRows, locator: TouchLocator, statistic: Statistic
) -> None:
    index = int(touched.points_of("l_forearm")[40])
    limb, push = touched.robot.subtree_of("l_forearm"), touched.push(index, 15.0)
    smooth, rough = [], []
    for step in range(120):
        rows = push + touched.noise(0.3)  # white noise is a part of what is expected
        add(locator, rows, statistic)
        if step >= 60 and step % 2:
            seen = locator.search(locator.look(touched.frame, [limb], [], 0.0, 0)).hypotheses[0]
            smooth.append(np.linalg.norm(seen.force))
            rough.append(np.linalg.norm(touched.rows.wrenches(rows)[limb][:3]))
    assert np.std(smooth) < 0.4 * np.std(rough)


def test_two_touched_limbs_are_both_located(touched: TouchedRows, locator: TouchLocator) -> None:
    arm, leg = (int(touched.points_of(link)[40]) for link in ("l_forearm", "r_upper_leg"))
    locator.add(touched.push(arm, 10.0) + touched.push(leg, 12.0), PERIOD)
    limbs = [touched.robot.subtree_of(link) for link in ("l_forearm", "r_upper_leg")]
    found = locator.search(locator.look(touched.frame, limbs, [], 0.0, 0))
    assert {h.links[0] for h in found.hypotheses[:2]} == {"l_forearm", "r_upper_leg"}
    forces = sorted(float(np.linalg.norm(h.force)) for h in found.hypotheses[:2])
    assert forces == pytest.approx([10.0, 12.0], abs=0.1)
    assert list(locator.map().limb) == ["l_arm", "r_leg"]


def test_a_limb_that_no_push_explains_is_not_hidden_by_another_that_one_does(
    touched: TouchedRows, locator: TouchLocator
) -> None:
    arm, leg = (int(touched.points_of(link)[40]) for link in ("l_forearm", "r_upper_leg"))
    limbs = [touched.robot.subtree_of(link) for link in ("l_forearm", "r_upper_leg")]
    twist = touched.at("l_forearm", np.zeros(3), np.array([20.0, 0.0, 0.0]))
    twist -= touched.at("l_forearm", np.array([0.0, 0.3, 0.0]), np.array([20.0, 0.0, 0.0]))
    locator.add(twist, PERIOD)
    alone = locator.search(locator.look(touched.frame, limbs[:1], [], 0.0, 0)).none_probability
    locator.reset()
    locator.add(touched.push(arm, 10.0) + touched.push(leg, 12.0), PERIOD)
    pushes = locator.search(locator.look(touched.frame, limbs, [], 0.0, 0)).none_probability
    locator.reset()
    locator.add(twist + touched.push(leg, 12.0), PERIOD)
    both = locator.search(locator.look(touched.frame, limbs, [], 0.0, 0)).none_probability
    assert alone > 0.9 and pushes < 0.1
    assert both >= alone


def test_a_touch_on_a_moving_arm_is_where_it_is_though_its_rows_are_smooth(
    touched: TouchedRows,
) -> None:
    robot, rows = touched.robot, ContactRows(touched.robot)
    locator = TouchLocator(rows, RowNoise(), 0.06, "surface")
    index = int(touched.points_of("l_hand")[40])
    point, normal = touched.surface.points[index], touched.surface.normals[index]
    wrench = np.concatenate((-15.0 * normal, np.cross(point, -15.0 * normal)))
    hand, frame = robot.links.index("l_hand"), touched.frame
    for step in range(100):
        q = frame.q.copy()
        q[robot.joints.index("l_elbow")] += 1.5 * PERIOD * step  # 1.5 rad/s
        rows.update(replace(frame, q=q))
        carried = rows.jacobian @ (rows.link_maps([hand])[0] @ wrench)
        locator.add(rows.remove(rows.layout.rows_of("l_hand") * carried, rows.removed), PERIOD)
    limb = robot.subtree_of("l_hand")
    best = locator.search(locator.look(replace(frame, q=q), [limb], [], 0.0, 0)).hypotheses[0]
    assert best.links[0] == "l_hand"
    assert np.linalg.norm(best.point - point) < 2e-3
    np.testing.assert_array_equal(rows.q[rows.layout.tree.joint_q], q)  # as it was


def test_the_map_holds_no_more_than_a_message_bears(
    touched: TouchedRows, locator: TouchLocator
) -> None:
    index = int(touched.points_of("chest")[40])
    locator.add(touched.push(index, 0.5), PERIOD)  # so little that it may be anywhere
    locator.search(locator.look(touched.frame, [touched.robot.subtree_of("chest")], [], 0.0, 0))
    places = locator.map()
    assert len(places.link) > 5
    assert 1000 < len(places.point) <= 1500
    assert len(places.probability) == sum(places.count) == len(places.point)
    np.testing.assert_allclose(np.linalg.norm(places.line_direction, axis=1), 1.0)
