"""The description of iCub: what the other parts of Wrenchbus count on."""

import hashlib
import subprocess
import sys
import time

import numpy as np
import pinocchio as pin
import pytest

from robot_model import load_robot


def test_icub_has_its_joints_sensors_and_parts(icub):
    assert icub.dimensions == {"n": 32, "k": 6, "m": 1}
    sides = [f"{side}_{limb}_ft" for limb in ("arm", "leg", "foot") for side in "lr"]
    assert list(icub.ft_sensors) == sides
    assert icub.imus == ("head_imu_0",)
    sizes = {part: len(joints) for part, joints in icub.parts.items()}
    limbs = {"left_arm": 7, "right_arm": 7, "left_leg": 6, "right_leg": 6}
    assert sizes == {"torso": 3, "head": 3, **limbs}
    assert icub.part_sensors["left_leg"].tolist() == [2, 4]
    assert sorted(np.concatenate(list(icub.parts.values()))) == list(range(32))


def test_model_hash_is_that_of_the_joint_names(icub):
    text = "\n".join(icub.joints).encode()
    assert icub.model_hash == hashlib.sha256(text).hexdigest()[:8]


def test_subtrees_follow_the_sensors(icub):
    names = [subtree.name for subtree in icub.subtrees]
    assert names == ["root", "l_arm", "r_arm", "l_leg", "r_leg", "l_foot", "r_foot"]
    assert [subtree.ft_in for subtree in icub.subtrees] == [-1, 0, 1, 2, 3, 4, 5]
    outs = [subtree.ft_out for subtree in icub.subtrees]
    assert outs == [(0, 1, 2, 3), (), (), (4,), (5,), (), ()]
    assert sorted(link for subtree in icub.subtrees for link in subtree.links) == sorted(icub.links)
    for index, subtree in enumerate(icub.subtrees):
        assert icub.subtree_of(subtree.default_frame) == index
        assert icub.frame(subtree.default_frame)[0] == subtree.default_link
    assert icub.subtree_of("l_hip_2") == 0 and icub.subtree_of("l_hip_3") == 3


def test_a_frame_is_found_on_the_link_that_bears_it(icub):
    link, placement = icub.frame("l_sole")
    assert link == "l_foot"
    np.testing.assert_allclose(placement.translation, [0.0035, 0.0, 0.004])
    assert icub.frame("chest")[1].isIdentity()


def test_unknown_links_are_answered_with_a_near_name(icub):
    assert icub.require_link("chest") == "chest"
    with pytest.raises(LookupError, match="icub has no link 'l_forarm'; did you mean 'l_forearm'"):
        icub.require_link("l_forarm")
    with pytest.raises(LookupError, match="did you mean 'l_sole'"):
        icub.frame("l_soel")
    with pytest.raises(LookupError, match="no link 'tail'"):
        icub.subtree_of("tail")


def test_home_stands_on_flat_soles_with_the_mass_over_the_feet(icub):
    tree, data = icub.tree, icub.tree.model.createData()
    q = tree.configuration(icub.home)
    pin.framesForwardKinematics(tree.model, data, q)
    center = pin.centerOfMass(tree.model, data, q)
    soles = [data.oMf[tree.frame_id(frame)] for frame in icub.supports["floor"]]
    for sole in soles:
        np.testing.assert_allclose(sole.rotation[:, 2], [0.0, 0.0, 1.0], atol=1e-9)
        assert sole.actInv(center)[0] == pytest.approx(0.022, abs=1e-3)
    assert soles[0].translation[2] == pytest.approx(soles[1].translation[2], abs=1e-4)
    assert (soles[0].translation + soles[1].translation)[1] == pytest.approx(0.0, abs=1e-3)


def test_the_root_looks_backward(icub):
    data = icub.tree.model.createData()
    pin.framesForwardKinematics(icub.tree.model, data, icub.tree.configuration(icub.home))
    sole = data.oMf[icub.tree.frame_id("l_sole")]
    np.testing.assert_allclose(sole.rotation[:, 0], [-1.0, 0.0, 0.0], atol=1e-9)
    assert sole.translation[1] < 0.0


def test_sole_corners_lie_on_the_lowest_face_of_the_foot(icub):
    bodies = {body.name: body for body in icub.load_surface().bodies}
    for frame, corners in icub.soles.items():
        link, placement = icub.frame(frame)
        vertices = (bodies[link].vertices - placement.translation) @ placement.rotation
        lowest = vertices[vertices[:, 2] < vertices[:, 2].min() + 0.001]
        assert corners[:, 2] == pytest.approx(vertices[:, 2].min(), abs=1e-4)
        np.testing.assert_allclose(corners.max(0)[:2], lowest.max(0)[:2], atol=0.002)
        np.testing.assert_allclose(corners.min(0)[:2], lowest.min(0)[:2], atol=0.002)


def test_rotor_inertia_is_symmetric_positive_and_coupled(icub):
    inertia = icub.rotor_inertia
    np.testing.assert_array_equal(inertia, inertia.T)
    assert np.linalg.eigvalsh(inertia).min() > 0.0
    pitch, roll = icub.joints.index("l_shoulder_pitch"), icub.joints.index("l_shoulder_roll")
    assert inertia[pitch, roll] < 0.0
    knee = icub.joints.index("l_knee")
    assert inertia[knee, knee] == pytest.approx(1e4 * 9.2e-6)


def test_limits_are_sensible_everywhere(icub):
    assert np.all(icub.position_lower < icub.home) and np.all(icub.home < icub.position_upper)
    assert np.all((0.1 < icub.velocity_limit) & (icub.velocity_limit < 20.0))
    assert np.all((0.1 < icub.torque_limit) & (icub.torque_limit < 200.0))


def test_loading_is_quick_and_leaves_slow_libraries_alone():
    load_robot()
    seconds = []
    for _ in range(5):
        start = time.process_time()  # of this process: other jobs may be running
        load_robot()
        seconds.append(time.process_time() - start)
    assert min(seconds) < 0.060
    code = "import robot_model as r; r.load_robot()"
    loaded = modules_after(code)
    assert not {"scipy", "trimesh", "viser", "matplotlib"} & loaded


def modules_after(code: str) -> set[str]:
    command = [sys.executable, "-c", f"{code}; import sys; print(*sys.modules)"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_messages_and_port_names_need_no_pinocchio():
    code = "import robot_model.messages, robot_model.ports"
    loaded = modules_after(code)
    assert not {"pinocchio", "pydantic"} & loaded
