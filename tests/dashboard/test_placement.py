import numpy as np
import pinocchio as pin
import pytest


def test_base_is_where_its_pose_says(robot, placement):
    turned = placement.vector(robot.base_link, np.array([1.0, 0.0, 0.0]))
    assert placement.point(robot.base_link, np.zeros(3)) == pytest.approx([0.0, 0.0, 0.6])
    assert turned == pytest.approx([0.0, 1.0, 0.0])


def test_inverse_vector_undoes_vector(robot, placement):
    vector = np.array([1.0, -2.0, 3.0])
    there = placement.vector("l_forearm", vector)
    assert placement.inverse_vector("l_forearm", there) == pytest.approx(vector)


def test_chain_of_relative_poses_ends_where_the_link_is(robot, placement):
    links = robot.links
    parents = placement.parents(links)
    poses = placement.poses(links, parents)
    i = links.index("l_hand")
    chain = pin.SE3.Identity()
    while i >= 0:
        chain = pin.XYZQUATToSE3(poses[i]) * chain
        i = parents[i]
    assert chain.translation == pytest.approx(placement.point("l_hand", np.zeros(3)))


def test_only_the_base_hangs_on_the_world(robot, placement):
    parents = placement.parents(robot.links)
    assert parents.count(-1) == 1 and parents[robot.links.index(robot.base_link)] == -1


def test_body_beyond_a_force_torque_sensor_hangs_on_the_same_carrier_as_the_body_before_it(
    robot, placement
):
    links = ("l_upper_arm", "l_shoulder_3", "l_shoulder_2")
    parents = placement.parents(links)
    assert parents[0] == parents[1] == 2
