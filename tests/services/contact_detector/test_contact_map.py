"""The map of the touches on the bus, for a page that colours the robot."""

from itertools import accumulate, pairwise

import numpy as np
import pinocchio as pin

from bus import Received
from robot_model import Robot
from robot_model.messages import ContactMap
from tests.services.contact_detector.conftest import Bench, Recording, later


def of(limbs: list[str], since: int):
    """Maps that tell these limbs, of frames since a stamp."""
    return lambda one: one.data.limb == limbs and one.envelope.stamp >= since


def on(places: ContactMap, link: str) -> tuple[np.ndarray, np.ndarray]:
    """Points of one link and their probabilities."""
    ends = list(pairwise([0, *accumulate(places.count)]))
    i, j = ends[places.link.index(link)]
    return places.point[i:j], places.probability[i:j]


def placed(robot: Robot, link: str, q: np.ndarray) -> pin.SE3:
    """Placement of a link in the base's frame."""
    model = robot.tree.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, robot.tree.configuration(q))
    return data.oMf[robot.tree.frame_id(link)]


def test_a_push_is_a_spot_on_the_map_with_a_line_through_it(
    bench: Bench, robot: Robot, recording: Recording
) -> None:
    bench.read_maps(robot)
    bench.feed(recording.quiet)
    bench.feed(recording.pushed)
    late = recording.pushed[-20][0]
    received = bench.maps(of(["l_arm"], late))
    best = bench.contacts(lambda one: bool(one.data.hypotheses)).data.hypotheses[0]
    places = received.data
    assert received.envelope.valid
    assert sum(places.count) == len(places.point) == len(places.probability)
    assert {robot.subtrees[robot.subtree_of(link)].name for link in places.link} == {"l_arm"}
    assert 0.9 < places.probability.sum() <= 1.0 + 1e-9
    points, share = on(places, "l_forearm")
    assert np.linalg.norm(points[share.argmax()] - best["point"]) < 0.015
    line = places.line_direction[0]
    link = placed(robot, "l_forearm", recording.pushed[-1][1].q)
    across = link.act(np.array(best["point"])) - places.line_point[0]
    assert np.linalg.norm(across - line * (across @ line)) < 0.005
    push = link.rotation @ np.array(best["force"])
    assert push @ line > 0.99 * np.linalg.norm(push)


def test_the_map_is_empty_when_the_touch_is_over(
    bench: Bench, robot: Robot, recording: Recording
) -> None:
    bench.read_maps(robot)
    bench.feed(recording.quiet)
    bench.feed(recording.pushed)
    bench.feed(later(recording.quiet[:60], 3.0))
    over: Received = bench.maps(of([], recording.pushed[-1][0] + 1))
    assert over.data.point.shape == (0, 3)
    assert not over.data.count


def test_maps_come_as_often_as_places_are_looked_for_and_only_to_readers(
    bench: Bench, robot: Robot, recording: Recording
) -> None:
    bench.feed(recording.quiet)
    bench.feed(recording.pushed)
    assert bench.written("contact_map", robot) == 0
    bench.read_maps(robot)
    again = later(recording.pushed, 0.5)
    bench.feed(again)
    bench.maps(of(["l_arm"], again[-20][0]))
    seconds = (again[-1][0] - again[0][0]) * 1e-9
    # messages of silence may come between
    assert bench.written("contact_map", robot) >= 20.0 * seconds - 2


def test_before_the_tare_the_map_is_invalid_and_says_why(
    bench: Bench, robot: Robot, recording: Recording
) -> None:
    bench.read_maps(robot)
    bench.feed(recording.quiet[:50])
    said = bench.maps(lambda one: "tare" in one.envelope.reason)
    assert not said.envelope.valid
    assert not said.data.link
