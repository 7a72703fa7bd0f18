"""Pushes of 15 N on the standing robot, two per link: are they seen, and placed right?"""

import json
from itertools import islice

import numpy as np
import pytest

from experiments.touch import main, run_touches, summary
from experiments.touch_pushes import CONE, PushGenerator
from robot_model import Robot, load_robot

UNSEEN = 40  # seed; noise and levels were chosen on others


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("icub")


@pytest.mark.timeout(900)  # a push takes a second on an idle machine
def test_exact_sensors_name_the_link_and_the_point(robot: Robot) -> None:
    figures = summary(run_touches(robot, UNSEEN, 26, "ideal"))
    assert figures["links"] >= 12
    assert figures["subtrees"] == ["l_arm", "l_leg", "r_arm", "r_leg", "root"]
    assert figures["detected"] == 1.0
    assert figures["first"] >= 0.9
    assert figures["point_median"] < 0.005


@pytest.mark.timeout(900)
def test_noisy_tared_sensors_have_the_link_among_the_first_three(robot: Robot) -> None:
    figures = summary(run_touches(robot, UNSEEN, 26, "realistic"))
    assert figures["links"] >= 12
    assert figures["detected"] == 1.0
    assert figures["flagged_elsewhere"] <= 0.05
    assert figures["among_three"] >= 0.9


def test_pushes_press_into_the_surface_above_the_feet(robot: Robot) -> None:
    surface = robot.load_surface()
    names = [body.name for body in surface.bodies]
    for push in islice(PushGenerator(robot, 3), 60):
        assert "foot" not in robot.subtrees[robot.subtree_of(push.link)].name
        mine = np.flatnonzero(surface.body == names.index(push.link))
        near = mine[np.linalg.norm(surface.points[mine] - push.point, axis=1) < 0.02]
        inward = -surface.normals[near] @ push.force / np.linalg.norm(push.force)
        assert inward.max() > np.cos(1.5 * CONE)


def test_equal_seeds_give_equal_pushes(robot: Robot) -> None:
    first, second = (list(islice(PushGenerator(robot, 7), 5)) for _ in range(2))
    for one, other in zip(first, second, strict=True):
        assert one.link == other.link
        np.testing.assert_array_equal(one.force, other.force)


def test_the_command_prints_one_document(capsys: pytest.CaptureFixture[str], tmp_path) -> None:
    main(["--seed", "1", "--runs", "1", "--profile", "ideal", "--json", "-o", str(tmp_path)])
    printed = json.loads(capsys.readouterr().out)
    assert printed["pushes"] == 1
    assert json.loads((tmp_path / "touch.json").read_text()) == printed


def test_an_unknown_way_to_draw_places_is_refused(robot: Robot) -> None:
    with pytest.raises(ValueError, match="surface, links"):
        PushGenerator(robot, 1, places="everywhere")
