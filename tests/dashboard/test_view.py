"""The scene without a browser: what the server would send."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from dashboard.chart import ResidualChart
from dashboard.config import DashboardConfig
from dashboard.likelihood import FAINT, drawn_parts
from dashboard.robot_scene import BODY, STALE
from dashboard.snapshot import Snapshot
from dashboard.view import View
from robot_model.messages import ContactMap, Contacts, Residuals
from tests.dashboard.feeder import Feeder, FeederConfig


@pytest.fixture
def view(server, robot):
    return View(server.scene, robot, robot.load_surface(), DashboardConfig())


@pytest.fixture
def known(robot) -> Snapshot:
    """What a feeder says while it is pushed at the left forearm."""
    said = Feeder.silent(robot, FeederConfig())
    said.push = {"link": "l_forearm", "point": [0.0, 0.0, 0.1], "force": [20.0, 0.0, 0.0]}
    names = ("sensors", "base", "torques", "wrenches", "residuals", "contacts", "truth")
    names += ("contact_map",)
    return Snapshot(**{name: getattr(said, name)() for name in names})


def colours(view: View) -> dict[str, Any]:
    scene = view._robot
    return {link: mesh.color for link, mesh in zip(scene.links, scene._meshes, strict=True)}


def update(view: View, known: Snapshot, show_truth: bool = True) -> None:
    view.update(known, show_truth, hide_below=1.0)


def test_estimated_robot_is_never_placed_from_truth(view, known):
    update(view, known)
    before = view.estimate.point("l_hand", np.zeros(3))
    update(
        view, replace(known, truth=replace(known.truth, base_position=np.array([9.0, 9.0, 9.0])))
    )
    assert view.estimate.point("l_hand", np.zeros(3)) == pytest.approx(before)


def test_robot_without_sensor_frames_turns_grey_and_loses_its_arrows(view, known):
    update(view, known)
    assert view._forces._supports.visible
    update(view, replace(known, sensors=None))
    assert set(colours(view).values()) == {tuple(STALE)}
    assert not view._forces._supports.visible


def test_robot_without_a_base_estimate_turns_grey(view, known):
    update(view, replace(known, base=None))
    assert set(colours(view).values()) == {tuple(STALE)}


def test_touched_link_is_tinted_and_the_best_hypothesis_named(view, known):
    update(view, known)
    tinted = {link for link, colour in colours(view).items() if colour != tuple(BODY)}
    assert tinted == {"l_forearm"}
    assert view._forces._label.text == "l_forearm 20.0 N p=0.90"


def test_hypotheses_go_when_the_contact_goes(view, known):
    update(view, replace(known, contact_map=None))
    assert view._forces._hypotheses.visible and view._forces._label.visible
    update(view, replace(known, contacts=Contacts(flags=[], hypotheses=[])))
    assert not view._forces._hypotheses.visible
    assert not view._forces._label.visible
    assert not view._forces._best.visible


def test_map_of_a_touch_is_coloured_dots_on_the_body_and_a_line(view, known):
    update(view, known)
    (cloud,) = view._likelihood._clouds.values()
    assert cloud.visible and cloud.name.endswith("/l_forearm/likelihood")
    assert 10 < len(cloud.points) < known.contact_map.count[0]
    brightest = cloud.points[np.argmax(cloud.colors.sum(axis=1))]
    assert brightest == pytest.approx(known.contacts.hypotheses[0]["point"], abs=0.06)
    assert view._forces._lines.visible and view._forces._lines.points.shape == (1, 2, 3)
    assert not view._forces._hypotheses.visible  # the map says more


@pytest.mark.parametrize("what", ["contact_map", "contacts", "sensors"])
def test_map_and_line_go_when_nothing_is_known_of_a_touch(view, known, what):
    update(view, known)
    update(view, replace(known, **{what: None}))
    assert not any(cloud.visible for cloud in view._likelihood._clouds.values())
    assert not view._forces._lines.visible


def test_map_is_not_shown_while_no_limb_is_touched(view, known):
    quiet = [flag | {"state": "none"} for flag in known.contacts.flags]
    update(view, replace(known, contacts=Contacts(flags=quiet, hypotheses=[])))
    assert not view._likelihood._clouds and not view._forces._lines.visible


def test_brightness_falls_with_the_logarithm_and_the_improbable_is_not_drawn():
    found = ContactMap(
        link=["a", "b"],
        count=[3, 1],
        point=np.arange(12.0).reshape(4, 3),
        probability=np.array([0.5, 0.5 * FAINT**0.5, 0.0, 0.1 * FAINT]),
        limb=[],
        line_point=np.zeros((0, 3)),
        line_direction=np.zeros((0, 3)),
    )
    ((link, (points, brightness)),) = drawn_parts(found).items()
    assert link == "a" and brightness == pytest.approx([1.0, 0.5])
    assert points == pytest.approx(found.point[:2])
    nothing = replace(found, link=[], count=[], point=np.zeros((0, 3)), probability=np.zeros(0))
    assert drawn_parts(nothing) == {}


def test_wrench_that_the_data_leave_open_is_grey_and_says_so(view, known):
    said = known.wrenches
    hand = len(said.frame) - 1
    said.wrench[hand, :3] = [0.0, 0.0, 12.0]
    decided = [i != hand for i in range(len(said.frame))]
    update(view, replace(known, wrenches=replace(said, decided=decided)))
    scene = view._forces
    assert scene._undecided.visible and not scene._touches.visible
    assert scene._open.visible and scene._open.text == "undecided"
    update(view, known)
    assert scene._touches.visible and not scene._undecided.visible and not scene._open.visible


def test_truth_can_be_switched_off(view, known):
    update(view, known)
    assert view._forces._needles.visible
    assert len(view._forces._needles.points) == 3  # one push, two soles
    update(view, known, show_truth=False)
    assert not view._forces._needles.visible and not view._forces._balls.visible


def test_camera_stands_where_the_configuration_says_in_the_bases_axes(view, known):
    assert view.camera() is None
    update(view, known)
    position, look_at = view.camera()
    offset = DashboardConfig().camera_offset
    assert position == pytest.approx(known.base.position + offset)
    assert look_at == pytest.approx(known.base.position)


def test_chart_shows_the_classical_residual_while_only_that_is_valid(server, robot):
    chart = ResidualChart(server.gui, robot, points=10, seconds=1.0)
    n = robot.n
    pole = Residuals(
        internal=np.zeros(n),
        external=np.zeros(6),
        classical=np.full(n, 0.7),
        threshold_internal=np.full(n, 2.0),
        threshold_external=np.ones(6),
        valid_internal=False,
        valid_external=False,
        valid_classical=True,
    )
    chart.add(0.0, pole)
    chart.add(0.1, pole)
    chart.draw()
    _, residual, upper, lower = chart._plot.data
    assert residual == pytest.approx([0.7, 0.7])
    assert upper == pytest.approx([2.0, 2.0]) and lower == pytest.approx(-upper)


def test_chart_leaves_a_gap_where_residuals_are_missing(server, robot, known):
    chart = ResidualChart(server.gui, robot, points=10, seconds=1.0)
    chart.add(0.0, known.residuals)
    chart.add(0.1, None)
    chart.draw()
    assert np.isnan(chart._plot.data[1]).tolist() == [False, True]


def test_chart_does_not_begin_with_a_gap(server, robot, known):
    chart = ResidualChart(server.gui, robot, points=3, seconds=1.0)  # the oldest one goes
    for time, residuals in enumerate((known.residuals, None, known.residuals, known.residuals)):
        chart.add(float(time), residuals)
    chart.draw()
    assert not np.isnan(chart._plot.data[1]).any() and len(chart._plot.data[1]) == 2
