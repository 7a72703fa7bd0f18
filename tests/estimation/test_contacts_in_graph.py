"""Several contacts on one sub-graph, from the readings to the joint torques (N, 3.2)."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from estimation.contact_set import Touch
from estimation.contact_wrenches import contact_wrenches, force_along, pure_force
from estimation.graph.enhanced_graph import EnhancedGraph, enhanced_graph
from estimation.graph.graph_dynamics import GraphWrenches, predict_readings, solve_wrenches
from estimation.graph.graph_kinematics import FrameMotion, solve_kinematics
from estimation.graph.graph_parts import Leaf
from estimation.torque_observer import TorqueObserver
from robot_model import Robot
from tests.estimation.observer_states import ObserverInput, random_input

HAND = Leaf("hand", "l_hand", pin.SE3(np.eye(3), np.array([0.01, 0.0, 0.02])))
FOREARM = Leaf("forearm", "l_forearm", pin.SE3(np.eye(3), np.array([0.0, 0.04, -0.05])))
NORMAL = np.array([0.0, 1.0, 0.0])
TRUTH = {
    "hand": np.array([3.0, -4.0, 5.0, 0.0, 0.0, 0.0]),
    "forearm": np.array([0.0, -8.0, 0.0, 0.0, 0.0, 0.0]),
}


class TouchedArm:
    """iCub in random motion, touched at two places of its left arm."""

    def __init__(self, robot: Robot):
        self.state: ObserverInput = random_input(robot, np.random.default_rng(11))
        s = self.state
        self.graph: EnhancedGraph = replace(enhanced_graph(robot), known=(HAND, FOREARM))
        imu, motion = self.graph.inertial[0], FrameMotion(s.gyro, s.dgyro, s.acc)
        self.motions = solve_kinematics(self.graph, imu, motion, s.q, s.dq, s.ddq)
        self.ft = predict_readings(self.graph, self.motions, s.q, imu.link, TRUTH)

    def wrenches(self, known: dict[str, np.ndarray]) -> GraphWrenches:
        return solve_wrenches(self.graph, self.motions, self.state.q, self.ft, known)


@pytest.fixture(scope="module")
def touched(robot: Robot) -> TouchedArm:
    return TouchedArm(robot)


def in_frame(robot: Robot, q: np.ndarray, frame: str, leaf: Leaf) -> pin.SE3:
    """Placement of a leaf in a frame of its sub-graph, by Pinocchio's own model."""
    model, data = robot.tree.model, robot.tree.model.createData()
    pin.framesForwardKinematics(model, data, robot.tree.configuration(q))
    world_m_link = data.oMf[robot.tree.frame_id(leaf.link)]
    return data.oMf[robot.tree.frame_id(frame)].actInv(world_m_link * leaf.placement)


def test_the_net_wrench_of_the_observer_is_shared_as_it_acts(robot, touched):
    observer, arm = TorqueObserver(robot), robot.subtree_of("l_hand")
    net = observer.step(*touched.state._replace(ft=touched.ft)).subtree_wrench[arm]
    frame, q = robot.subtrees[arm].default_frame, touched.state.q
    hand = pure_force(in_frame(robot, q, frame, HAND))
    forearm = force_along(in_frame(robot, q, frame, FOREARM), NORMAL)
    shared = contact_wrenches([hand, forearm]).solve(net)
    np.testing.assert_allclose(shared.wrench, list(TRUTH.values()), atol=1e-9)
    np.testing.assert_allclose(shared.residual, 0.0, atol=1e-9)


def test_with_all_contacts_known_every_other_subgraph_closes(touched):
    found = touched.wrenches(TRUTH).unknown
    roots = [links[0] for links in touched.graph.subgraphs]
    assert max(np.abs(found[root]).max() for root in roots[1:]) < 1e-10


def test_contacts_move_the_torques_of_the_joints_between_them_and_the_sensor(robot, touched):
    """By the transposed Jacobians of the two points, for the joints of the arm."""
    observer = TorqueObserver(robot)
    estimate = observer.step(*touched.state._replace(ft=touched.ft))
    torque = touched.wrenches(TRUTH).torque
    lump = observer.contacts[robot.subtree_of("l_hand")]
    net = Leaf("net", lump.link, lump.placement)
    wrenches = {"net": estimate.wrench[lump.subtree], **TRUTH}
    change = np.zeros(robot.n)
    model, data = robot.tree.model, robot.tree.model.createData()
    full = robot.tree.configuration(touched.state.q)
    for leaf, sign in ((net, 1.0), (HAND, -1.0), (FOREARM, -1.0)):
        jacobian = pin.computeFrameJacobian(model, data, full, robot.tree.frame_id(leaf.link))
        in_link = leaf.placement.act(pin.Force(wrenches[leaf.name])).vector
        change += sign * (jacobian.T @ in_link)[robot.tree.joint_v]
    arm = [robot.joints.index(name) for name in robot.joints if name.startswith(("l_elb", "l_wri"))]
    assert np.abs(change[arm]).max() > 0.1
    np.testing.assert_allclose((torque - estimate.torque)[arm], change[arm], atol=1e-9)


TOUCHES = [
    Touch("l_hand", HAND.placement.translation, "force"),
    Touch("l_forearm", FOREARM.placement.translation, "direction", NORMAL),
]


def at_root(touched: TouchedArm) -> Touch:
    """The contact at which the graph's solution leaves what holds the robot up."""
    return Touch(touched.graph.subgraphs[0][0], np.zeros(3))


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_the_observer_shares_them_live_and_every_joint_feels_its_own(robot, touched, order):
    observer, arm = TorqueObserver(robot), robot.subtree_of("l_hand")
    observer.set_contacts([*(TOUCHES[i] for i in order), at_root(touched)])
    estimate = observer.step(*touched.state._replace(ft=touched.ft))
    rows = [i for i, contact in enumerate(observer.contacts) if contact.subtree == arm]
    truth = [list(TRUTH.values())[i] for i in order]
    np.testing.assert_allclose(estimate.wrench[rows], truth, atol=1e-9)
    np.testing.assert_allclose(estimate.torque, touched.wrenches(TRUTH).torque, atol=1e-9)
    assert estimate.unexplained is not None and estimate.decision is not None
    np.testing.assert_allclose(estimate.unexplained, 0.0, atol=1e-9)
    assert estimate.decision.rank[arm] == 4 and estimate.decision.decided.all()


def test_a_known_wrench_leaves_the_rest_to_the_other_contact(robot, touched):
    observer, arm = TorqueObserver(robot), robot.subtree_of("l_hand")
    known = Touch("l_forearm", FOREARM.placement.translation, "known", TRUTH["forearm"])
    hand = Touch("l_hand", HAND.placement.translation)
    observer.set_contacts([known, hand, at_root(touched)])
    estimate = observer.step(*touched.state._replace(ft=touched.ft))
    rows = [i for i, contact in enumerate(observer.contacts) if contact.subtree == arm]
    truth = [TRUTH["forearm"], TRUTH["hand"]]
    np.testing.assert_allclose(estimate.wrench[rows], truth, atol=1e-9)
    np.testing.assert_allclose(estimate.torque, touched.wrenches(TRUTH).torque, atol=1e-9)


def test_what_no_contact_explains_is_told_and_acts_on_no_joint_of_its_subtree(robot, touched):
    observer, arm = TorqueObserver(robot), robot.subtree_of("l_hand")
    state = touched.state._replace(ft=touched.ft)
    lump = observer.step(*state)
    free = TorqueObserver(robot).step(*touched.state._replace(ft=lump.predicted))
    observer.set_contacts([Touch("l_hand", np.zeros(3), "none")])
    estimate = observer.step(*state)
    np.testing.assert_allclose(estimate.unexplained[arm], lump.subtree_wrench[arm], atol=1e-9)
    inside = observer.graph.joint_subtree == arm
    assert inside.sum() > 2
    np.testing.assert_allclose(estimate.torque[inside], free.torque[inside], atol=1e-9)
    np.testing.assert_allclose(estimate.torque[~inside], lump.torque[~inside], atol=1e-9)


def test_what_two_full_wrenches_do_to_each_other_is_undecided_and_said_so(robot, touched):
    observer, arm = TorqueObserver(robot), robot.subtree_of("l_hand")
    state = touched.state._replace(ft=touched.ft)
    net = observer.step(*state).subtree_wrench
    observer.set_contacts([("l_hand", np.zeros(3)), ("l_forearm", np.zeros(3))])
    estimate = observer.step(*state)
    decision = estimate.decision
    np.testing.assert_allclose(estimate.subtree_wrench, net, atol=1e-9)
    assert decision.rank[arm] == 6 and decision.undecided.shape == (6, len(observer.contacts), 6)
    pair = np.array([contact.subtree == arm for contact in observer.contacts])
    np.testing.assert_array_equal(decision.decided, ~pair)
    assert not decision.undecided[:, ~pair].any()


def test_known_wrenches_are_those_of_the_graph(touched):
    with pytest.raises(LookupError, match=r"expected \['forearm', 'hand'\], got \['hand'\]"):
        touched.wrenches({"hand": TRUTH["hand"]})
