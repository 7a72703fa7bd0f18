"""Any wrench, asked for in any frame, against the graph's reference code and Pinocchio."""

import numpy as np
import pinocchio as pin
import pytest

from estimation.contact_set import Touch
from estimation.dependencies import ChannelDependencies
from estimation.graph.enhanced_graph import enhanced_graph
from estimation.graph.graph_dynamics import GraphWrenches, remaining_wrench, solve_wrenches
from estimation.graph.graph_kinematics import FrameMotion, solve_kinematics
from estimation.torque_observer import TorqueObserver
from estimation.wrench_query import WrenchQuery
from robot_model import Robot
from tests.estimation.observer_noise import NOISE
from tests.estimation.observer_states import random_input

STATE_SEED = 4


@pytest.fixture(scope="module")
def state(robot):
    return random_input(robot, np.random.default_rng(STATE_SEED))


@pytest.fixture(scope="module")
def query(robot, state) -> WrenchQuery:
    return WrenchQuery(TorqueObserver(robot), NOISE, *state)


@pytest.fixture(scope="module")
def graph(robot):
    return enhanced_graph(robot, TorqueObserver(robot).contacts)


@pytest.fixture(scope="module")
def motions(graph, state):
    motion = FrameMotion(state.gyro, state.dgyro, state.acc)
    return solve_kinematics(graph, graph.inertial[0], motion, state.q, state.dq, state.ddq)


@pytest.fixture(scope="module")
def reference(graph, motions, state) -> GraphWrenches:
    return solve_wrenches(graph, motions, state.q, state.ft)


def placed(robot: Robot, q: np.ndarray, frame: str) -> pin.SE3:
    """Placement of a frame in the base link, by Pinocchio's own model."""
    model, data = robot.tree.model, robot.tree.model.createData()
    pin.framesForwardKinematics(model, data, robot.tree.configuration(q))
    return data.oMf[robot.tree.frame_id(frame)]


def test_joints_bear_what_the_reference_code_says(robot, graph, query, reference, state):
    """The edges' frames are fixed in the parents, ours in the children."""
    for edge in graph.joints:
        wrench, frame, *_ = query.wrench(f"joint:{edge.name}")
        joint = robot.urdf.joints[edge.name]
        assert frame == joint.child
        angle = state.q[robot.joints.index(edge.name)]
        parent_m_child = pin.SE3(pin.exp3(joint.axis * angle), np.zeros(3))
        told = parent_m_child.act(pin.Force(wrench)).vector
        np.testing.assert_allclose(told, reference.through[edge.name], atol=1e-8)


def test_links_feel_newtons_and_eulers_equations(robot, query, motions):
    for name in ("head", "l_forearm", "chest", "r_foot", "root_link"):
        inertia = robot.urdf.links[name].inertia
        expected = remaining_wrench(inertia, motions[name], [], pin.SE3.Identity(), 1.0)
        np.testing.assert_allclose(query.wrench(f"link:{name}")[0], expected, atol=1e-9)


def test_contacts_subtrees_and_sensors_are_those_of_the_estimate(robot, query, state):
    estimate, contacts = query.estimate, TorqueObserver(robot).contacts
    for row, contact in enumerate(contacts):
        assert query.wrench(f"contact:{contact.frame}")[1] == contact.frame
        told = query.wrench(f"contact:{contact.frame}")[0]
        np.testing.assert_allclose(told, estimate.wrench[row], atol=1e-9)
    for row, subtree in enumerate(robot.subtrees):
        told = query.wrench(f"subtree:{subtree.name}")[0]
        np.testing.assert_allclose(told, estimate.subtree_wrench[row], atol=1e-9)
    for row, sensor in enumerate(robot.ft_sensors):
        np.testing.assert_allclose(query.wrench(f"sensor:{sensor}")[0], state.ft[row], atol=1e-9)


def test_frame_axes_and_point_are_as_asked(robot, query, state):
    point = np.array([0.1, -0.2, 0.3])
    own, frame, *_ = query.wrench("contact:l_sole")
    base_m_frame, base_m_hand = placed(robot, state.q, frame), placed(robot, state.q, "l_hand")
    about_base = base_m_frame.act(pin.Force(own))
    told = query.wrench("contact:l_sole", "l_hand", point=point)[0]
    expected = (base_m_hand * pin.SE3(np.eye(3), point)).actInv(about_base).vector
    np.testing.assert_allclose(told, expected, atol=1e-9)
    turned = query.wrench("contact:l_sole", "l_hand", axes="head", point=point)[0]
    rotation = placed(robot, state.q, "head").rotation.T @ base_m_hand.rotation
    np.testing.assert_allclose(turned[:3], rotation @ expected[:3], atol=1e-9)
    np.testing.assert_allclose(turned[3:], rotation @ expected[3:], atol=1e-9)


def test_joints_between_two_contacts_feel_the_one_beyond_them(robot, state):
    observer = TorqueObserver(robot)
    observer.set_contacts(
        [Touch("l_hand", np.array([0.0, 0.0, 0.05]), "force"), ("l_forearm", np.zeros(3))]
    )
    query = WrenchQuery(observer, NOISE, *state)
    axis = {joint.name: joint.axis for joint in robot.urdf.joints.values()}
    for name in ("l_elbow", "l_wrist_prosup", "l_wrist_pitch", "l_wrist_yaw", "l_shoulder_yaw"):
        wrench = query.wrench(f"joint:{name}")[0]
        torque = query.estimate.torque[robot.joints.index(name)]
        assert wrench[3:] @ axis[name] == pytest.approx(torque, abs=1e-8)


def test_a_lost_sensor_makes_invalid_what_depends_on_it_alone(robot, query):
    ft = np.array([name != "l_arm_ft" for name in robot.ft_sensors])
    joints, imu = np.ones(robot.n, dtype=bool), np.ones(1, dtype=bool)
    dependencies = ChannelDependencies(TorqueObserver(robot).graph)
    validity = dependencies.validity(joints, ft, imu)

    def lost(*of):
        return query.why_invalid(validity, *of) == "no data from l_arm_ft"

    invalid = ("contact:l_hand_dh_frame", "subtree:root", "sensor:l_arm_ft", "joint:l_elbow")
    assert all(lost(of) for of in (*invalid, "link:l_hand"))
    valid = ("contact:l_sole", "subtree:r_arm", "sensor:r_arm_ft", "joint:r_elbow", "link:r_foot")
    assert [query.why_invalid(validity, of) for of in valid] == [""] * 5
    assert lost("contact:l_sole", "l_hand") and not lost("contact:l_sole", "r_hand", "r_foot")
    whole = dependencies.validity(joints, ft | True, imu)
    assert query.why_invalid(whole, "contact:l_hand_dh_frame") == ""


@pytest.mark.parametrize(
    ("of", "text"),
    [
        ("l_hand", "expected KIND:NAME, KIND one of contact, subtree"),
        ("link:l_hnad", "did you mean 'l_hand'"),
        ("contact:l_hand", "no contact 'l_hand'"),
    ],
)
def test_what_does_not_exist_is_refused(query, of, text):
    with pytest.raises(LookupError, match=text):
        query.wrench(of)


def test_unknown_frames_are_refused(query):
    with pytest.raises(LookupError, match="did you mean 'l_hand'"):
        query.wrench("link:head", frame="l_hnad")
    with pytest.raises(ValueError, match="three finite numbers"):
        query.wrench("link:head", point=[0.0, np.inf, 0.0])
