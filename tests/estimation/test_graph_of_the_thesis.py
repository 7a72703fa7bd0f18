"""The mechanism of Figures 4.1 and 4.2 of the thesis of Fumagalli.

Links 0 to 6, an inertial sensor on 5, force/torque sensors in 2 and 4, contacts at 6, 1
and 3. A link with a sensor is two sub-links, B and F as the figures call them.
"""

import numpy as np
import pytest

from estimation.contact_set import contact_set
from estimation.graph.enhanced_graph import EnhancedGraph, enhanced_graph
from estimation.graph.graph_dynamics import solve_wrenches
from estimation.graph.graph_kinematics import FrameMotion, solve_kinematics
from estimation.torque_observer import TorqueObserver
from robot_model import Robot
from tests.estimation.observer_states import random_input
from tests.estimation.random_robots import described_robot

LINKS = {"0": 0, "1": 1, "4F": 2, "4B": 3, "5": 4, "6": 5, "2B": 6, "2F": 7, "3": 8}
NAMES = {f"link{index}": name for name, index in LINKS.items()}
# In the order in which the figures visit what hangs on a link.
JOINTS = [("5", "6"), ("4B", "5"), ("4F", "4B"), ("1", "4F"), ("0", "1"), ("1", "2B")]
JOINTS += [("2B", "2F"), ("2F", "3")]
CONTACTS = ["6", "1", "3"]


def name_of(link: str) -> str:
    return NAMES[link]


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    rng = np.random.default_rng(41)
    rows = [
        {
            "type": "sensor" if parent[0] == child[0] else "revolute",
            "parent": LINKS[parent],
            "child": LINKS[child],
            "xyz": rng.uniform(-0.3, 0.3, 3),
            "rpy": rng.uniform(-3.0, 3.0, 3),
            "axis": rng.normal(size=3),
        }
        for parent, child in JOINTS
    ]
    return described_robot(tmp_path_factory.mktemp("mechanism"), rows, [f"link{LINKS['5']}"])


@pytest.fixture(scope="module")
def graph(robot: Robot) -> EnhancedGraph:
    touches = [(f"link{LINKS[name]}", np.zeros(3)) for name in CONTACTS]
    contacts = contact_set(robot, "none", touches)
    return enhanced_graph(robot, contacts)


def test_seven_links_are_nine_nodes_six_joints_and_two_sensors(graph: EnhancedGraph):
    assert {name_of(link) for link in graph.links} == set(LINKS)
    assert len(graph.joints) == 6
    sides = {(name_of(edge.tail), name_of(edge.head)) for edge in graph.sensors}
    assert sides == {("4F", "4B"), ("2B", "2F")}


def test_white_triangles_sit_at_6_and_3(graph: EnhancedGraph):
    assert {name_of(link) for link in graph.kinematic_ends} == {"6", "3"}


def test_motion_is_computed_in_the_order_of_figure_4_1(robot: Robot, graph: EnhancedGraph):
    state = random_input(robot, np.random.default_rng(1))
    motion = FrameMotion(state.gyro, state.dgyro, state.acc)
    joints = state.q, state.dq, state.ddq
    order = [name_of(link) for link in solve_kinematics(graph, graph.inertial[0], motion, *joints)]
    assert order == ["5", "6", "4B", "4F", "1", "0", "2B", "2F", "3"]


def test_two_sensors_make_the_three_subgraphs_of_figure_4_2(graph: EnhancedGraph):
    subgraphs = {frozenset(map(name_of, links)) for links in graph.subgraphs}
    assert subgraphs == {
        frozenset({"4B", "5", "6"}),
        frozenset({"4F", "0", "2B", "1"}),
        frozenset({"2F", "3"}),
    }


@pytest.mark.parametrize(
    ("root", "order"),
    [("6", ["4B", "5", "6"]), ("1", ["4F", "0", "2B", "1"]), ("3", ["2F", "3"])],
)
def test_wrenches_are_computed_in_the_order_of_figure_4_2(graph, root, order):
    visit = graph.post_order(f"link{LINKS[root]}", cut=True)
    assert [name_of(step.link) for step in visit] == order


def test_the_figures_way_gives_the_observers_answer(robot: Robot, graph: EnhancedGraph):
    observer = TorqueObserver(robot, "none")
    observer.set_contacts([(leaf.link, np.zeros(3)) for leaf in graph.unknown])
    state = random_input(robot, np.random.default_rng(2))
    motion = FrameMotion(state.gyro, state.dgyro, state.acc)
    joints = state.q, state.dq, state.ddq
    motions = solve_kinematics(graph, graph.inertial[0], motion, *joints)
    result, estimate = solve_wrenches(graph, motions, state.q, state.ft), observer.step(*state)
    np.testing.assert_allclose(result.torque, estimate.torque, atol=1e-10)
    unknown = [result.unknown[contact.frame] for contact in observer.contacts]
    np.testing.assert_allclose(unknown, estimate.wrench, atol=1e-10)
