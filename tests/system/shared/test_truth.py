"""Over the bus, with ideal sensors, the estimates are what the plant knows."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
import pytest

from bus import Node
from bus.introspection import list_ports
from robot_model import Robot, messages, ports
from robot_model.messages import ExternalWrenches, GroundTruth, JointTorques
from tests.system.stack import Stack

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]
FORCE = np.array([0.0, 6.0, -8.0])  # N, in the world
PUSHES = {  # by default contact
    "chest": FORCE,
    "l_hand_dh_frame": -FORCE,
    "r_hand_dh_frame": FORCE,
    "l_lower_leg": -FORCE,
    "r_lower_leg": FORCE,
}
STILL = 0.02  # rad/s
TOLERANCE = np.array([0.2] * 3 + [0.05] * 3)  # N, N m


class Sample(NamedTuple):
    """What is known and what is estimated of one stamp."""

    truth: GroundTruth
    wrenches: ExternalWrenches
    torques: JointTorques


class Samples:
    """Joins truth and estimates by stamp."""

    def __init__(self, node: Node, robot: Robot):
        self._ports = {key: _listen(node, robot, key) for key in ("truth", "wrenches", "torques")}
        self._samples: dict[str, dict[int, Any]] = {key: {} for key in self._ports}

    def take(self, when: Callable[[GroundTruth], bool]) -> Sample | None:
        """Return a new sample whose truth satisfies ``when``, or None."""
        for key, port in self._ports.items():
            while (received := port.read()) is not None:
                if received.envelope.valid:
                    self._samples[key][received.envelope.stamp] = received.data
        truth, wrenches, torques = self._samples.values()
        stamps = [
            stamp for stamp in set(truth) & set(wrenches) & set(torques) if when(truth[stamp])
        ]
        return Sample(*(s[max(stamps)] for s in (truth, wrenches, torques))) if stamps else None


def _listen(node: Node, robot: Robot, key: str):
    return node.input(
        f"/truth_observer/{key}:i",
        getattr(messages, ports.port(key).message),
        source=ports.name(key, robot),
        depth=1000,
        model=robot.model_hash,
        dimensions=robot.dimensions,
    )


@pytest.fixture
def samples(stack: Stack) -> Iterator[Samples]:
    with Node("truth_observer", connect=stack.endpoint, signals=False) as node:
        samples = Samples(node, stack.robot)
        node.ready()
        yield samples


def world_from(robot: Robot, truth: GroundTruth, frame: str) -> np.ndarray:
    """Return R_world_frame of the true posture."""
    tree = robot.tree
    data = tree.model.createData()
    w, x, y, z = truth.base_quat_wxyz
    base = pin.SE3(pin.Quaternion(w, x, y, z).matrix(), truth.base_position)
    pin.framesForwardKinematics(tree.model, data, tree.configuration(truth.q, base))
    return data.oMf[tree.frame_id(frame)].rotation


def is_pushed_and_still(truth: GroundTruth) -> bool:
    full = sum(np.linalg.norm(push["force_world"]) > 9.99 for push in truth.pushes)
    return bool(full == len(PUSHES) and np.abs(truth.dq).max() < STILL)


def assert_supports_are_true(sample: Sample) -> None:
    for frame, wrench in zip(sample.truth.support_frames, sample.truth.support_wrench, strict=True):
        index = sample.wrenches.frame.index(frame)
        assert sample.wrenches.kind[index] == "support" and sample.wrenches.valid[index]
        assert (np.abs(sample.wrenches.wrench[index] - wrench) < TOLERANCE).all(), frame


def test_wrenches_and_torques_are_true_while_every_default_contact_is_pushed(
    stack: Stack, samples: Samples
):
    """All five at once, to and fro, so that the robot stays on its feet."""
    pushes = [_push(stack, frame, force) for frame, force in PUSHES.items()]
    try:
        sample = stack.until(
            lambda: samples.take(is_pushed_and_still),
            lambda: "the pushed robot does not come to rest",
        )
    finally:
        for push in pushes:
            stack.simulate("release", push_id=push)
    for frame, force in PUSHES.items():
        index = sample.wrenches.frame.index(frame)
        expected = np.zeros(6)
        expected[:3] = world_from(stack.robot, sample.truth, frame).T @ force
        assert sample.wrenches.valid[index]
        assert (np.abs(sample.wrenches.wrench[index] - expected) < TOLERANCE).all(), frame
    assert sample.torques.valid.all()
    np.testing.assert_allclose(sample.torques.torque, sample.truth.link_torque, atol=0.05)
    assert_supports_are_true(sample)


def _push(stack: Stack, frame: str, force: np.ndarray) -> int:
    link, link_m_frame = stack.robot.frame(frame)
    point = link_m_frame.translation.tolist()
    where = {"link": link, "point": point, "frame": "world", "profile": "ramp"}
    return stack.simulate("push", force=force.tolist(), **where)["push_id"]


def test_only_the_page_reads_the_truth(stack: Stack):
    truth = ports.name("truth", stack.robot)
    readers = {
        port["owner"]["service"]
        for port in list_ports(stack.node)
        if truth in port["sources"] and port["owner"]["service"] != "observer"
    }
    assert readers <= {"dashboard"}
