"""The recursions of the thesis, link by link, beside the observer's one pass."""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimation.graph.enhanced_graph import enhanced_graph
from estimation.graph.graph_dynamics import predict_readings, solve_wrenches
from estimation.graph.graph_kinematics import FrameMotion, at_rest, solve_kinematics
from estimation.torque_observer import TorqueObserver
from robot_model import load_robot
from tests.estimation.observer_states import ObserverInput, random_input
from tests.estimation.random_robots import described_robot, icub_with, random_joints

DATA = Path(__file__).parents[1] / "robot_model" / "data"


def assert_equal(ours: np.ndarray, theirs: np.ndarray) -> None:
    np.testing.assert_allclose(
        ours, theirs, rtol=0.0, atol=1e-10 * max(1.0, np.abs(theirs).max(initial=0.0))
    )


def motion_of(state: ObserverInput) -> FrameMotion:
    return FrameMotion(state.gyro, state.dgyro, state.acc)


def compare(observer: TorqueObserver, state: ObserverInput, turn: list[str] | None = None) -> None:
    """Both give the same torques, external wrenches and predicted readings."""
    graph = enhanced_graph(observer.robot, observer.contacts).turned(turn or [])
    source = graph.inertial[0]
    motions = solve_kinematics(graph, source, motion_of(state), state.q, state.dq, state.ddq)
    result = solve_wrenches(graph, motions, state.q, state.ft)
    estimate = observer.step(*state)
    assert_equal(result.torque, estimate.torque)
    unknown = [result.unknown[contact.frame] for contact in observer.contacts]
    assert_equal(np.array(unknown), estimate.wrench)
    predicted = predict_readings(graph, motions, state.q, source.link)
    assert_equal(predicted, estimate.predicted)


def touch_at_random(observer: TorqueObserver, rng: np.random.Generator) -> None:
    """Move the contacts of some sub-trees to any link of theirs."""
    subtrees = [tree for tree in observer.robot.subtrees if rng.random() < 0.7]
    touches = [(str(rng.choice(tree.links)), rng.uniform(-0.2, 0.2, 3)) for tree in subtrees]
    observer.set_contacts(touches)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.integers(0, 2**32 - 1), st.integers(1, 14), st.sampled_from([0.0, 0.2, 0.5]))
def test_both_agree_on_random_trees_sensors_and_contacts(seed, count, sensors):
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as directory:
        joints = random_joints(rng, count, sensors)
        robot = described_robot(Path(directory), joints, [f"link{rng.integers(count + 1)}"])
    observer = TorqueObserver(robot, "none")
    touch_at_random(observer, rng)
    turn = [name for name in robot.joints if rng.random() < 0.5]
    compare(observer, random_input(robot, rng), turn)


@pytest.mark.parametrize("name", ["icub", DATA / "arm.yaml", DATA / "talos.yaml", DATA / "g1.yaml"])
def test_both_agree_on_every_robot_wherever_its_inertial_sensor_is(name):
    robot, rng = load_robot(name), np.random.default_rng(3)
    for imu in [robot.imus[0], *rng.choice(robot.links, 3)]:
        observer = TorqueObserver(replace(robot, imus=(str(imu),)), "none")
        for _ in range(2):
            touch_at_random(observer, rng)
            compare(observer, random_input(robot, rng))


@pytest.mark.parametrize(
    "sensors",
    [
        [],
        ["l_foot_ft"],
        ["l_arm_ft", "r_arm_ft", "l_leg_ft", "r_leg_ft"],  # the thesis' iCub
        ["l_leg_ft", "l_foot_ft", "r_arm_ft"],
    ],
    ids=len,
)
def test_both_agree_on_icub_with_any_set_of_sensors(sensors, tmp_path):
    robot, rng = icub_with(tmp_path, sensors), np.random.default_rng(4)
    observer = TorqueObserver(robot, "pole")
    for _ in range(3):
        compare(observer, random_input(robot, rng))


@pytest.mark.parametrize("turn", ["none", "some", "all"])
def test_the_direction_of_an_edge_is_a_convention_only(turn):
    robot, rng = load_robot(DATA / "arm.yaml"), np.random.default_rng(5)
    observer = TorqueObserver(robot, "table")
    names = {"none": [], "some": ["slide"], "all": list(robot.joints)}[turn]
    for _ in range(5):
        compare(observer, random_input(robot, rng), names)


def test_turning_an_edge_turns_the_sign_of_its_wrench():
    robot, rng = load_robot(DATA / "arm.yaml"), np.random.default_rng(6)
    state = random_input(robot, rng)
    graph = enhanced_graph(robot)
    wrenches = []
    for each in (graph, graph.turned(["bend"])):
        motions = solve_kinematics(
            each, each.inertial[0], motion_of(state), state.q, state.dq, state.ddq
        )
        wrenches.append(solve_wrenches(each, motions, state.q, state.ft).through["bend"])
    bend = next(edge for edge in graph.joints if edge.name == "bend")
    in_head = bend.placement_in(bend.head, state.q).act(pin.Force(wrenches[0])).vector
    assert_equal(in_head, -wrenches[1])


def test_on_a_fixed_base_both_kinematic_sources_agree():
    robot, rng = load_robot("icub"), np.random.default_rng(7)
    state: ObserverInput = random_input(robot, rng)
    graph = enhanced_graph(robot)
    base = next(leaf for leaf in enhanced_graph(replace(robot, imus=("root_link",))).inertial)
    gravity = np.array([1.0, -2.0, -9.5])
    joints = state.q, state.dq, state.ddq
    fixed = solve_kinematics(graph, base, at_rest(gravity), *joints)
    imu = graph.inertial[0]
    at_imu = fixed[imu.link].shifted(imu.placement.translation).turned(imu.placement.rotation.T)
    measured = solve_kinematics(graph, imu, at_imu, *joints)
    for link, motion in fixed.items():
        for name in ("omega", "domega", "acceleration"):
            assert_equal(getattr(measured[link], name), getattr(motion, name))
    # The observer takes the fixed link for an inertial sensor that reads it.
    observer = TorqueObserver(replace(robot, imus=("root_link",)), "pole")
    compare(observer, state._replace(gyro=np.zeros(3), dgyro=np.zeros(3), acc=-gravity))


def test_a_subgraph_without_contact_gives_equations_without_unknowns():
    robot, rng = load_robot("icub"), np.random.default_rng(8)
    state = random_input(robot, rng)
    graph = enhanced_graph(robot)
    motions = solve_kinematics(
        graph, graph.inertial[0], motion_of(state), state.q, state.dq, state.ddq
    )
    reading = predict_readings(graph, motions, state.q, graph.inertial[0].link)
    free = solve_wrenches(graph, motions, state.q, reading)
    roots = [links[0] for links in graph.subgraphs]
    assert list(free.unknown) == roots
    assert max(np.abs(free.unknown[root]).max() for root in roots[1:]) < 1e-10


def test_a_known_wrench_is_taken_off_the_unknown_one():
    robot, rng = load_robot("icub"), np.random.default_rng(9)
    observer = TorqueObserver(robot)
    state = random_input(robot, rng)
    graph = enhanced_graph(robot, observer.contacts)
    motions = solve_kinematics(
        graph, graph.inertial[0], motion_of(state), state.q, state.dq, state.ddq
    )
    whole = solve_wrenches(graph, motions, state.q, state.ft)
    hand = replace(graph.unknown[1], name="skin")
    wrench = rng.normal(size=6)
    rest = solve_wrenches(
        replace(graph, known=(hand,)), motions, state.q, state.ft, {"skin": wrench}
    )
    name = graph.unknown[1].name
    assert_equal(rest.unknown[name] + wrench, whole.unknown[name])
    assert_equal(rest.torque, whole.torque)


def test_two_unknowns_in_one_subgraph_are_refused():
    observer = TorqueObserver(load_robot("icub"))
    graph = enhanced_graph(observer.robot, [*observer.contacts, observer.contacts[1]])
    with pytest.raises(ValueError, match="one unknown wrench per sub-graph, got l_hand_dh_frame"):
        solve_wrenches(graph, {}, np.zeros(32), np.zeros((6, 6)))


def test_turning_a_sensor_or_an_unknown_joint_is_refused():
    graph = enhanced_graph(load_robot("icub"))
    with pytest.raises(LookupError, match="no joint 'l_elbw' to turn; did you mean 'l_elbow'"):
        graph.turned(["l_elbw"])
    with pytest.raises(LookupError, match="no joint 'l_arm_ft'"):
        graph.turned(["l_arm_ft"])
