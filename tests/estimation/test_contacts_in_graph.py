"""Several contacts on one sub-graph, from the readings to the joint torques (N, 3.2)."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from estimation.contact_wrenches import ContactWrenches, force_along, pure_force
from estimation.enhanced_graph import EnhancedGraph, enhanced_graph
from estimation.graph_dynamics import GraphWrenches, predict_readings, solve_wrenches
from estimation.graph_kinematics import FrameMotion, solve_kinematics
from estimation.graph_parts import Leaf
from estimation.torque_observer import TorqueObserver
from robot_model import Robot, load_robot
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
def robot() -> Robot:
    return load_robot("icub")


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
    shared = ContactWrenches([hand, forearm]).solve(net)
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


def test_known_wrenches_are_those_of_the_graph(touched):
    with pytest.raises(LookupError, match=r"expected \['forearm', 'hand'\], got \['hand'\]"):
        touched.wrenches({"hand": TRUTH["hand"]})
