"""One lost channel costs what depends on it, and nothing else."""

import numpy as np
import pytest

from estimation.contact_set import Touch
from estimation.dependencies import ChannelDependencies
from estimation.torque_observer import TorqueObserver
from robot_model import load_robot
from tests.estimation.observer_states import random_input

ROBOT = load_robot("icub")


TOUCHES = {
    "one wrench each": [],
    "several": [
        ("l_forearm", np.array([0.0, 0.0, 0.05])),
        Touch("l_hand", np.array([0.02, 0.03, 0.01]), "force"),
        Touch("l_upper_leg", np.zeros(3), "known", np.ones(6)),
        Touch("r_hand", np.zeros(3), "none"),
        Touch("head", np.array([0.0, 0.1, 0.1]), "force"),
    ],
}


@pytest.fixture(scope="module", params=TOUCHES)
def observer(request):
    result = TorqueObserver(ROBOT, "pole")
    result.set_contacts(TOUCHES[request.param])
    return result


@pytest.fixture(scope="module")
def dependencies(observer):
    return ChannelDependencies(observer.graph)


def lose(dependencies, joint=None, ft=None, imu=None, faults=()):
    flags = [np.ones(ROBOT.dimensions[d], dtype=bool) for d in "nkm"]
    for flag, index in zip(flags, (joint, ft, imu), strict=True):
        if index is not None:
            flag[index] = False
    return dependencies.validity(*flags, faults)


def differing(ours, theirs):
    return np.abs(ours - theirs).reshape(len(ours), -1).max(axis=1) > 1e-9


def test_with_every_channel_everything_is_valid(dependencies):
    validity = lose(dependencies)
    assert validity.complete and validity.reason == ""
    assert validity.torque.all() and validity.subtree.all() and validity.prediction.all()


@pytest.mark.parametrize("sensor", range(6))
def test_a_lost_sensor_invalidates_exactly_what_its_reading_changes(observer, dependencies, sensor):
    state = random_input(ROBOT, np.random.default_rng(sensor))
    ft = state.ft.copy()
    ft[sensor] += 10.0
    one, other = observer.step(*state), observer.step(*state._replace(ft=ft))
    validity = lose(dependencies, ft=sensor)
    np.testing.assert_array_equal(
        ~validity.subtree, differing(one.subtree_wrench, other.subtree_wrench)
    )
    lost = ~validity.subtree[[contact.subtree for contact in observer.contacts]]
    assert not (differing(one.wrench, other.wrench) & ~lost).any()
    np.testing.assert_array_equal(~validity.torque, differing(one.torque, other.torque))
    assert (~validity.subtree).sum() == 2
    assert ROBOT.ft_sensors[sensor] in validity.reason


@pytest.mark.parametrize("joint", range(ROBOT.n))
def test_a_lost_joint_invalidates_all_that_its_motion_changes(observer, dependencies, joint):
    state = random_input(ROBOT, np.random.default_rng(joint))
    q, dq, ddq = state.q.copy(), state.dq.copy(), state.ddq.copy()
    q[joint] += 0.5
    dq[joint] += 1.0
    ddq[joint] += 2.0
    one = observer.step(*state)
    other = observer.step(*state._replace(q=q, dq=dq, ddq=ddq))
    validity = lose(dependencies, joint=joint)
    assert not (validity.subtree & differing(one.subtree_wrench, other.subtree_wrench)).any()
    assert not (validity.torque & differing(one.torque, other.torque)).any()
    assert not (validity.prediction & differing(one.predicted, other.predicted)).any()


def test_a_lost_elbow_costs_one_arm(dependencies):
    validity = lose(dependencies, joint=ROBOT.joints.index("l_elbow"))
    lost = {ROBOT.subtrees[i].name for i in np.flatnonzero(~validity.subtree)}
    assert lost == {"l_arm"}


def test_without_the_inertial_sensor_nothing_is_valid(dependencies):
    validity = lose(dependencies, imu=0)
    assert not (validity.torque.any() or validity.subtree.any() or validity.prediction.any())
    assert ROBOT.imus[0] in validity.reason


def test_each_result_says_why_it_is_invalid_and_names_only_what_it_needs(dependencies):
    elbow, foot = ROBOT.joints.index("l_elbow"), ROBOT.ft_sensors.index("r_foot_ft")
    validity = lose(dependencies, joint=elbow, ft=foot)
    why = dict(zip([s.name for s in ROBOT.subtrees], validity.subtree_reasons, strict=True))
    assert why["l_arm"] == "no data from l_elbow"
    assert why["r_leg"] == why["r_foot"] == "no data from r_foot_ft"
    assert why["root"] == why["r_arm"] == ""
    assert [not reason for reason in validity.torque_reasons] == validity.torque.tolist()
    assert validity.prediction_reasons[foot] == "no data from r_foot_ft"
    assert validity.reason == "no data from l_elbow, r_foot_ft"


def test_a_fault_that_is_known_stands_in_the_place_of_no_data(dependencies):
    foot = ROBOT.ft_sensors.index("r_foot_ft")
    faults = ["r_foot_ft: saturated (fz reached 2000 N)"]
    validity = lose(dependencies, joint=ROBOT.joints.index("l_elbow"), ft=foot, faults=faults)
    assert validity.reason == "no data from l_elbow; r_foot_ft is saturated (fz reached 2000 N)"
    assert validity.prediction_reasons[foot] == "r_foot_ft is saturated (fz reached 2000 N)"
    again = lose(dependencies, ft=foot)
    assert again.prediction_reasons[foot] == "no data from r_foot_ft"
