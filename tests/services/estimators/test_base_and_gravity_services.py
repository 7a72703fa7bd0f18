"""Base estimator and gravity compensator as processes."""

import time

import numpy as np
import pytest

from bus import Node
from bus.envelope import Received
from robot_model import load_robot, ports
from robot_model.messages import BaseState
from robot_sim import Plant
from tests.services.estimators.feed import Feed, says

ROBOT = load_robot("icub")
SECOND = 1_000_000_000  # ns


@pytest.fixture
def plant() -> Plant:
    return Plant(ROBOT)


def test_the_base_is_estimated_where_the_plant_has_it(node: Node, start, plant):
    start("services.base_estimator")
    feed = Feed(node, plant, "base_estimator")
    base = feed.listen("base")
    node.ready()
    said = feed.until(lambda: says(base, True)).data
    truth = plant.truth()
    np.testing.assert_allclose(said.position, truth.base_position, atol=0.005)
    assert abs(said.quat_wxyz @ truth.base_quat_wxyz) > 1.0 - 1e-4
    assert (np.diag(said.covariance) > 0.0).all()


def test_the_base_is_invalid_without_load_and_after_silence(node: Node, start, plant):
    start("services.base_estimator")
    feed = Feed(node, plant, "base_estimator")
    base = feed.listen("base")
    node.ready()
    feed.until(lambda: says(base, True))
    feed.changes = {"ft": np.zeros((6, 6))}
    lifted = feed.until(lambda: says(base, False))
    assert "bears load" in lifted.envelope.reason or "no data" in lifted.envelope.reason
    feed.changes = {}
    feed.until(lambda: says(base, True))
    while (silent := says(base, False)) is None:
        node.wait(0.1)
    assert "no data" in silent.envelope.reason


def test_a_silence_that_is_said_at_the_last_stamp_is_passed_on(node: Node, start, plant):
    start("services.base_estimator")
    feed = Feed(node, plant, "base_estimator")
    base = feed.listen("base")
    node.ready()
    feed.until(lambda: says(base, True))
    feed.until(lambda: plant.time // 1_000_000 % 4 == 1)  # the next estimate is not yet due
    deadline = time.monotonic() + 20.0
    while (silent := says(base, False)) is None or silent.envelope.reason != "unplugged":
        assert time.monotonic() < deadline
        feed.write(valid=False, reason="unplugged")
        node.wait(0.005)


def test_a_clock_that_jumps_back_starts_the_base_anew(node: Node, start, plant):
    start("services.base_estimator")
    feed = Feed(node, plant, "base_estimator")
    base = feed.listen("base")
    node.ready()

    def said_at(begin: int, end: int) -> Received | None:
        said = says(base, True)
        return said if said is not None and begin < said.envelope.stamp < end else None

    feed.until(lambda: said_at(SECOND, 2 * SECOND))  # so what comes later is not older
    plant.reset()
    said = feed.until(lambda: said_at(0, SECOND))
    np.testing.assert_allclose(said.data.position, plant.truth().base_position, atol=0.005)


def test_gravity_torques_need_the_base_and_hold_the_arms(node: Node, start, plant):
    start("services.gravity_compensator")
    feed = Feed(node, plant, "gravity_compensator")
    gravity = feed.listen("gravity")
    bases = feed.writer(ports.service_input(ROBOT, "gravity_compensator", "base"), BaseState)
    node.ready()
    without = feed.until(lambda: says(gravity, False))
    assert without.envelope.reason

    def with_base():
        truth = plant.truth()
        state = BaseState(
            position=truth.base_position,
            quat_wxyz=truth.base_quat_wxyz,
            twist=truth.base_twist,
            covariance=np.eye(12),
        )
        bases.write(state, stamp=plant.time, clock=1)
        return says(gravity, True)

    torque = feed.until(with_base).data.torque
    elbow = ROBOT.joints.index("l_elbow")
    assert abs(torque[elbow]) > 0.1
    np.testing.assert_allclose(torque[elbow], torque[ROBOT.joints.index("r_elbow")], atol=0.05)
