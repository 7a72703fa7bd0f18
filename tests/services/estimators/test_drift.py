"""The observer follows drift with the contact detector as witness."""

from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import ValidationError

from bus import RpcError
from estimation.dependencies import ChannelDependencies
from estimation.torque_observer import TorqueObserver
from robot_model import load_robot, ports
from services.torque_observer.config import DriftConfig, TorqueObserverConfig
from services.torque_observer.drift import Drift

ROBOT = load_robot("icub")
K = len(ROBOT.ft_sensors)
ARM = ROBOT.ft_sensors.index("l_arm_ft")


class Witness:
    """An input on which a contact detector speaks."""

    def __init__(self):
        self.touched, self.valid, self.fresh = "", True, True

    def newest(self):
        flags = [
            {
                "limb": subtree.name,
                "state": "contact" if subtree.name == self.touched else "none",
                "valid": True,
            }
            for subtree in ROBOT.subtrees
        ]
        data, envelope = SimpleNamespace(flags=flags), SimpleNamespace(valid=self.valid)
        return SimpleNamespace(data=data, envelope=envelope)


class Bench:
    """An observer on the pole whose sensors all read 0.5 N too much along y."""

    def __init__(self):
        self.observer, self.witness = TorqueObserver(ROBOT, "pole"), Witness()
        self.observer.offset = np.full((K, 6), 1e-9)
        self.drift = Drift(self.observer, self.witness, DriftConfig(follow=True))
        whole = (np.ones(size, dtype=bool) for size in (ROBOT.n, K, len(ROBOT.imus)))
        self.validity = ChannelDependencies(self.observer.graph).validity(*whole)
        self.error = np.zeros((K, 6))
        self.error[:, 1] = 0.5
        self.stamp = 0

    def run(self, seconds):
        for _ in range(round(seconds / 0.1)):
            self.stamp += 100_000_000
            measured = self.error - self.observer.offset
            estimate = SimpleNamespace(predicted=np.zeros((K, 6)), measured=measured)
            self.drift.follow(estimate, self.validity, self.stamp)


@pytest.fixture
def bench():
    return Bench()


def test_offsets_follow_where_the_detector_sees_no_touch(bench):
    bench.witness.touched = "l_arm"
    bench.run(100.0)
    learnt = bench.observer.offset[:, 1]
    assert abs(learnt[ARM]) < 1e-6 and (np.delete(learnt, ARM) > 0.45).all()
    assert set(bench.drift.status()["followed"]) == set(ROBOT.ft_sensors) - {"l_arm_ft"}


def test_an_invalid_detector_freezes(bench):
    bench.witness.valid = False
    bench.run(60.0)
    assert np.abs(bench.observer.offset).max() < 1e-6


def test_a_tare_begins_anew_and_an_untared_observer_follows_nothing(bench):
    bench.run(60.0)
    tared = np.full((K, 6), 0.25)
    bench.observer.offset = tared
    bench.run(0.1)
    np.testing.assert_array_equal(bench.observer.offset, tared)
    assert not np.any(list(bench.drift.status()["drift"].values()))
    bench.observer.offset = np.zeros((K, 6))
    bench.run(60.0)
    assert not bench.observer.offset.any()


def test_lockstep_and_drift_exclude_each_other():
    with pytest.raises(ValidationError, match="expected false in lockstep"):
        TorqueObserverConfig(lockstep=True, drift=DriftConfig(follow=True))


def test_the_service_reads_contacts_only_when_it_follows_drift(node, start):
    start("services.torque_observer", "--set", "drift.follow=true")
    node.ready()
    status = node.call(ports.rpc("torque_observer"), "status", timeout=10.0)
    assert status["drift"]["followed"] == [] and set(status["drift"]["drift"]) == set(
        ROBOT.ft_sensors
    )
    assert status["tare"]["loaded"] == "not asked for"
    with pytest.raises(RpcError, match="drift.follow cannot be changed"):
        request = {"action": "set", "name": "drift.follow", "value": False}
        node.call(ports.rpc("torque_observer"), "param", request)
