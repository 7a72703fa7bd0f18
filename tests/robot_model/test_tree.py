"""Models rooted anywhere and cut at the sensors obey the same mechanics as the URDF."""

import numpy as np
import pinocchio as pin
import pytest

from robot_model import build_tree

LOCKED = {"grip": 0.4, "gripper_left_joint": 0.0, "gripper_right_joint": 0.0}


def pinocchio_model(robot):
    """Pinocchio's own reading of the URDF, and where our joints lie in it."""
    # Pinocchio turns a continuous joint into two numbers in q; ours stays one.
    text = robot.urdf.path.read_text()
    text = text.replace('type="continuous">', 'type="revolute">')
    model = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    locked = {name: at for name, at in LOCKED.items() if model.existJointName(name)}
    if locked:
        q = pin.neutral(model)
        for name, at in locked.items():
            q[model.joints[model.getJointId(name)].idx_q] = at
        model = pin.buildReducedModel(model, [model.getJointId(name) for name in locked], q)
    joints = [model.joints[model.getJointId(name)] for name in robot.joints]
    return model, joints


def test_total_mass_of_icub_is_that_of_the_urdf(icub):
    assert icub.mass == pytest.approx(33.062, abs=5e-4)
    for tree in (icub.tree, build_tree(icub, "l_hand", cut=True)):
        assert pin.computeTotalMass(tree.model) == pytest.approx(icub.mass, abs=1e-12)


def test_the_tree_equals_pinocchios_own_reading(robot, random):
    tree, (model, joints) = build_tree(robot, robot.urdf.root), pinocchio_model(robot)
    theirs_q = [joint.idx_q for joint in joints]
    theirs_v = np.r_[0:6, [joint.idx_v for joint in joints]]
    ours_v = np.r_[0:6, tree.joint_v]
    q, dq, ddq = random.uniform(-1, 1, (3, robot.n))
    base = pin.SE3(pin.exp3(random.normal(size=3)), random.normal(size=3))
    twist, acceleration = random.normal(size=(2, 6))
    their_q, (their_v, their_a) = pin.neutral(model), np.zeros((2, model.nv))
    their_q[:7], their_q[theirs_q] = pin.SE3ToXYZQUAT(base), q
    their_v[theirs_v], their_a[theirs_v] = np.r_[twist, dq], np.r_[acceleration, ddq]
    theirs = pin.rnea(model, model.createData(), their_q, their_v, their_a)[theirs_v]
    our_q, our_v = tree.configuration(q, base), tree.velocity(dq, twist)
    data = tree.model.createData()
    ours = pin.rnea(tree.model, data, our_q, our_v, tree.velocity(ddq, acceleration))[ours_v]
    np.testing.assert_allclose(ours, theirs, atol=1e-10 * max(1.0, abs(theirs).max()))
    their_inertia = symmetric(pin.crba(model, model.createData(), their_q))
    our_inertia = symmetric(pin.crba(tree.model, data, our_q))
    np.testing.assert_allclose(
        our_inertia[np.ix_(ours_v, ours_v)],
        their_inertia[np.ix_(theirs_v, theirs_v)],
        atol=1e-10,
    )


def symmetric(upper):
    return np.triu(upper) + np.triu(upper, 1).T


def test_every_urdf_link_is_where_pinocchio_puts_it(icub, random):
    tree, (model, joints) = icub.tree, pinocchio_model(icub)
    q = random.uniform(-1, 1, icub.n)
    their_q = pin.neutral(model)
    their_q[[joint.idx_q for joint in joints]] = q
    theirs, ours = model.createData(), tree.model.createData()
    pin.framesForwardKinematics(model, theirs, their_q)
    pin.framesForwardKinematics(tree.model, ours, tree.configuration(q))
    for link in icub.urdf.links:
        their_pose = theirs.oMf[model.getFrameId(link, pin.FrameType.BODY)]
        assert ours.oMf[tree.frame_id(link)].isApprox(their_pose, 1e-10), link


ROOTS = {
    "icub": ["head_imu_0", "l_hand", "r_sole", "l_upper_arm", "chest"],
    "tiny": ["finger", "hand", "wrench", "stick", "world_mount"],
    "talos": ["imu_link", "gripper_left_base_link", "right_sole_link"],
}


@pytest.mark.parametrize("cut", [False, True])
def test_joint_torques_do_not_depend_on_the_root(robot, cut, make_motion):
    for root in ROOTS[robot.name]:
        motion = make_motion(robot)
        tree = build_tree(robot, root, cut=cut)
        pose, twist, acceleration = motion.of(root)
        torque = pin.rnea(
            tree.model,
            tree.model.createData(),
            tree.configuration(motion.q, pose),
            tree.velocity(motion.dq, twist),
            tree.velocity(motion.ddq, acceleration),
        )
        expected = motion.torque[robot.tree.joint_v]
        np.testing.assert_allclose(torque[tree.joint_v], expected, atol=1e-9)
        np.testing.assert_allclose(torque[:6], 0.0, atol=1e-9)


@pytest.mark.parametrize("sensor", range(6))
def test_a_hanging_limb_reads_its_weight_upwards(icub, sensor, random):
    """One test per sensor, arms included; rooted on either side of it."""
    readings, pose, weight = static_reading(icub, sensor, "root_link", random)
    force_world = pose.rotation @ readings[:3]
    np.testing.assert_allclose(force_world, [0.0, 0.0, weight], atol=1e-10)
    subtree = icub.subtrees[sensor + 1]
    readings, pose, _ = static_reading(icub, sensor, subtree.default_link, random)
    rest = 9.81 * icub.mass - weight  # the limb now holds up everything else
    force_world = pose.rotation @ readings[:3]
    np.testing.assert_allclose(force_world, [0.0, 0.0, -rest], atol=1e-9)


def static_reading(robot, sensor, root, random):
    tree = build_tree(robot, root, cut=True)
    base = pin.SE3(pin.exp3(random.normal(size=3)), np.zeros(3))
    q = tree.configuration(robot.home + random.uniform(-0.2, 0.2, robot.n), base)
    data = tree.model.createData()
    torque = pin.rnea(tree.model, data, q, np.zeros(tree.model.nv), np.zeros(tree.model.nv))
    pin.framesForwardKinematics(tree.model, data, q)
    pose = data.oMf[tree.frame_id(robot.ft_frames[sensor])]
    hanging = [robot.subtrees[sensor + 1]]
    hanging += [robot.subtrees[i + 1] for i in hanging[0].ft_out]
    weight = 9.81 * sum(robot.bodies[link].mass for part in hanging for link in part.links)
    return tree.cut_sign[sensor] * torque[tree.cut_v[sensor]], pose, weight


def test_a_reading_is_what_the_parent_exerts_whatever_the_root(robot, make_motion):
    """Same motion, rooted on both sides: the readings agree."""
    motion = make_motion(robot)
    readings = []
    for root in ROOTS[robot.name]:
        tree = build_tree(robot, root, cut=True)
        pose, twist, acceleration = motion.of(root)
        torque = pin.rnea(
            tree.model,
            tree.model.createData(),
            tree.configuration(motion.q, pose),
            tree.velocity(motion.dq, twist),
            tree.velocity(motion.ddq, acceleration),
        )
        readings.append(tree.cut_sign[:, None] * torque[tree.cut_v])
    for reading in readings[1:]:
        np.testing.assert_allclose(reading, readings[0], atol=1e-9)


def test_a_cut_joint_sits_in_the_frame_of_its_sensor(robot, make_motion):
    for root in ROOTS[robot.name]:
        tree, motion = build_tree(robot, root, cut=True), make_motion(robot)
        data = tree.model.createData()
        pose = motion.of(root)[0]
        pin.framesForwardKinematics(tree.model, data, tree.configuration(motion.q, pose))
        for element, frame in zip(robot.ft_elements, robot.ft_frames, strict=True):
            joint = data.oMi[tree.model.getJointId(element.joint)]
            assert joint.isApprox(data.oMf[tree.frame_id(frame)], 1e-12)
            assert joint.isApprox(motion.of(frame)[0], 1e-9)


def test_the_jacobian_of_a_leaf_carries_wrenches_of_its_frame(icub, make_motion, random):
    offset = pin.SE3(pin.exp3(random.normal(size=3)), random.normal(size=3))
    tree = build_tree(icub, "head_imu_0", cut=True, leaves=[("touch", "l_forearm", offset)])
    motion = make_motion(icub)
    q = tree.configuration(motion.q, motion.of("head_imu_0")[0])
    data = tree.model.createData()
    jacobian = pin.computeJointJacobians(tree.model, data, q)
    wrench = random.normal(size=6)
    world = jacobian[:, tree.leaf_v["touch"]] @ wrench
    placement = motion.of("l_forearm")[0] * offset
    expected = placement.toActionMatrix() @ wrench
    np.testing.assert_allclose(world, expected, atol=1e-9)


def test_a_leaf_changes_no_torque(tiny, make_motion):
    motion = make_motion(tiny)
    leaves = [("first", "fore", pin.SE3.Identity()), ("second", "hand", pin.SE3.Identity())]
    plain, leafy = build_tree(tiny, cut=True), build_tree(tiny, cut=True, leaves=leaves)
    torques = [
        pin.rnea(
            tree.model,
            tree.model.createData(),
            tree.configuration(motion.q),
            tree.velocity(motion.dq),
            tree.velocity(motion.ddq),
        )
        for tree in (plain, leafy)
    ]
    np.testing.assert_allclose(torques[1][leafy.joint_v], torques[0][plain.joint_v], atol=1e-12)
    assert list(leafy.leaf_v) == ["first", "second"]


def test_models_with_cuts_and_leaves_serve_every_algorithm(icub, random):
    """Sub-trees are contiguous in v, so crba and aba agree with rnea on them too."""
    leaves = [("palm", "l_hand", pin.SE3.Identity()), ("knee", "r_lower_leg", pin.SE3.Identity())]
    tree = build_tree(icub, "head_imu_0", cut=True, leaves=leaves)
    data = tree.model.createData()
    q = tree.configuration(icub.home + random.uniform(-0.3, 0.3, icub.n))
    a = random.normal(size=tree.model.nv)
    still = np.zeros(tree.model.nv)
    inertia = symmetric(pin.crba(tree.model, data, q))
    difference = pin.rnea(tree.model, data, q, still, a) - pin.rnea(
        tree.model, data, q, still, still
    )
    np.testing.assert_allclose(inertia @ a, difference, atol=1e-9)


def test_configuration_and_velocity_write_in_place(icub):
    tree = build_tree(icub, "head_imu_0", cut=True)
    q, v = tree.configuration(icub.home), tree.velocity(icub.home)
    assert tree.configuration(icub.home + 1.0, out=q) is q
    assert tree.velocity(icub.home + 1.0, np.arange(6.0), out=v) is v
    np.testing.assert_array_equal(q[tree.joint_q], icub.home + 1.0)
    np.testing.assert_array_equal(v[:6], np.arange(6.0))
    assert pin.isNormalized(tree.model, q)


def test_an_unknown_root_is_refused_with_a_near_name(icub):
    with pytest.raises(LookupError, match="no frame 'head_imu'.*did you mean 'head_imu_0'"):
        build_tree(icub, "head_imu")
    with pytest.raises(LookupError, match="did you mean 'l_hand'"):
        icub.tree.frame_id("l_hnd")


def test_a_perturbation_scales_the_links_it_names(icub):
    heavy = build_tree(icub, perturbation={"chest": 1.5})
    extra = pin.computeTotalMass(heavy.model) - icub.mass
    assert extra == pytest.approx(0.5 * icub.bodies["chest"].mass)


def test_perturbed_masses_stay_within_the_bound_and_follow_the_seed(icub):
    wrong = icub.perturbed(3, 0.02)
    ratios = [
        wrong.urdf.links[link].inertia.mass / icub.urdf.links[link].inertia.mass
        for link in icub.links
    ]
    assert max(np.abs(np.array(ratios) - 1.0)) <= 0.02 + 1e-12
    assert 0.003 < np.std(ratios) < 0.02
    again, other = icub.perturbed(3, 0.02), icub.perturbed(4, 0.02)
    assert pin.computeTotalMass(again.tree.model) == pin.computeTotalMass(wrong.tree.model)
    assert wrong.mass == pytest.approx(pin.computeTotalMass(wrong.tree.model))
    assert pin.computeTotalMass(other.tree.model) != pin.computeTotalMass(wrong.tree.model)
