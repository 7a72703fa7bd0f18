"""``wrenchbus estimate``: what it says of the simulated robot is the truth."""

import numpy as np
import pinocchio as pin
import pytest

from deploy.progress import ProgressBar
from robot_model import Robot, load_robot
from tests.deploy.simulated_log import (
    EXACT,
    FORCE,
    LINK,
    POINT,
    PUSHED,
    Simulated,
    estimated,
    simulate,
    without,
)

TOUCH = f"{LINK}:{','.join(str(x) for x in POINT)}"
SETTLED = 300  # tick from which the residuals have followed the push


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("icub")


@pytest.fixture(scope="module")
def standing(robot) -> Simulated:
    return simulate(robot, "free", 400)


@pytest.fixture(scope="module")
def hanging(robot) -> Simulated:
    return simulate(robot, "fixed", 400)


def up_in_base(log: Simulated) -> np.ndarray:
    """Return upwards in the axes of the base, (3,)."""
    x, y, z, w = log.truth[0].base_quat_wxyz[[1, 2, 3, 0]]
    return pin.Quaternion(w, x, y, z).matrix()[2]


def test_torques_and_wrenches_of_exact_sensors_are_the_truth(standing, tmp_path):
    found = estimated(standing.arrays, tmp_path, "--contact", TOUCH)
    assert found["valid_joint_torque"].all() and found[f"valid_wrench_{LINK}"].all()
    assert abs(found["joint_torque"] - standing.true("link_torque")).max() < 1e-9
    expected = np.zeros((400, 6))
    expected[PUSHED:, :3] = FORCE
    assert abs(found[f"wrench_{LINK}"] - expected).max() < 1e-9
    support = standing.true("support_wrench")
    assert abs(found["wrench_l_sole"] - support[:, 0]).max() < 1e-9
    assert abs(found["wrench_r_sole"] - support[:, 1]).max() < 1e-9
    assert (found["joint_torque_std"] > 0.0).all() and (found[f"wrench_{LINK}_std"] > 0.0).all()


def test_every_array_has_its_pinned_name_and_shape(robot, standing, tmp_path):
    found = estimated(standing.arrays, tmp_path)
    size, n = 400, robot.n
    assert found["joint_names"].tolist() == list(robot.joints)
    assert found["stamp"].tolist() == standing.arrays["stamp"].tolist()
    shapes = {"joint_torque": (n,), "residual_internal": (n,), "residual_external": (6,)}
    shapes |= {"residual_classical": (n,), "valid_residual_internal": ()}
    shapes |= {"wrench_chest": (6,), "valid_wrench_chest": (6,), "ft_predicted_l_arm_ft": (6,)}
    shapes |= {"contact_probability": (3,), "contact_link": (3,), "none_probability": ()}
    shapes |= {"contact_point": (3, 3), "contact_force": (3, 3)}
    assert {name: found[name].shape for name in shapes} == {
        name: (size, *shape) for name, shape in shapes.items()
    }


def test_the_order_of_joint_names_does_not_matter(robot, standing, tmp_path):
    order = np.random.default_rng(1).permutation(robot.n)
    changed = dict(standing.arrays)
    for name in ("q", "dq", "ddq", "motor_torque"):
        changed[name] = standing.arrays[name][:, order]
    changed["joint_names"] = np.array(robot.joints)[order]
    first, second = (estimated(a, tmp_path) for a in (standing.arrays, changed))
    assert all((first[name] == second[name]).all() for name in first)


def test_a_fixed_link_in_the_place_of_the_imu_says_the_same(robot, hanging, tmp_path):
    arrays = without(hanging.arrays, "imu_gyro", "imu_acc", "imu_dgyro", "motor_torque")
    arrays |= {"fixed_link": np.array(robot.base_link), "gravity": -9.81 * up_in_base(hanging)}
    options = ("--support", "pole", "--contact", TOUCH)
    by_link = estimated(arrays, tmp_path, *options)
    by_imu = estimated(hanging.arrays, tmp_path, *options)
    for name in ("joint_torque", "wrench_root_link", f"wrench_{LINK}"):
        assert abs(by_link[name] - by_imu[name]).max() < 1e-9, name
    assert abs(by_link["joint_torque"] - hanging.true("link_torque")).max() < 1e-9
    assert "residual_internal" not in by_link


def test_gravity_of_an_upright_link_is_the_default(robot, hanging, tmp_path):
    arrays = without(hanging.arrays, "imu_gyro", "imu_acc", "imu_dgyro")
    arrays["fixed_link"] = np.array(robot.base_link)
    stated = arrays | {"gravity": np.array([0.0, 0.0, -9.81])}
    first, second = (estimated(a, tmp_path, "--support", "pole") for a in (arrays, stated))
    assert (first["joint_torque"] == second["joint_torque"]).all()


def test_motion_is_estimated_where_it_is_missing(standing, tmp_path):
    found = estimated(without(standing.arrays, *EXACT), tmp_path, "--contact", TOUCH)
    valid = np.logical_and.reduce(found["valid_joint_torque"], axis=1)
    assert valid[24:-24].all() and not valid[:24].any() and not valid[-24:].any()
    assert not found["joint_torque"][~valid].any()
    calm = slice(SETTLED, 400 - 24)  # a step of force leaves the window
    error = found["joint_torque"][calm] - standing.true("link_torque")[calm]
    assert abs(error).max() < 0.05


def test_a_touch_is_found_and_the_residuals_follow_it(robot, standing, tmp_path):
    found = estimated(standing.arrays, tmp_path)
    before, after = slice(0, PUSHED), slice(SETTLED, None)
    assert (found["none_probability"][before] == 1.0).all()
    assert not found["contact_probability"][before].any()
    assert (found["contact_link"][after, 0] == LINK).all()
    assert (found["contact_probability"][after, 0] > 0.9).all()
    assert abs(found["contact_force"][after, 0] - FORCE).max() < 1.5
    assert abs(found["contact_point"][after, 0] - POINT).max() < 0.03
    assert abs(found["residual_external"][before]).max() < 0.3
    force = np.linalg.norm(found["residual_external"][-1, :3])
    assert force == pytest.approx(np.linalg.norm(FORCE), rel=0.02)
    flags = ("internal", "external", "classical")
    assert all(found[f"valid_residual_{name}"].all() for name in flags)


def test_link_torques_serve_as_well_as_motor_torques(standing, tmp_path):
    by_link = without(standing.arrays, "motor_torque")
    by_link["link_torque"] = standing.true("link_torque")
    first, second = (estimated(a, tmp_path) for a in (standing.arrays, by_link))
    for name in ("residual_internal", "residual_external"):
        assert abs(first[name]).max() > 1.0
        assert abs(first[name] - second[name]).max() < 0.1, name
    assert (first["contact_link"][SETTLED:, 0] == second["contact_link"][SETTLED:, 0]).all()


def test_on_a_pole_the_attitude_is_given_or_follows_from_the_fixed_link(robot, hanging, tmp_path):
    given = hanging.arrays | {"base_quat_wxyz": hanging.true("base_quat_wxyz")}
    fixed = without(hanging.arrays, "imu_gyro", "imu_acc", "imu_dgyro")
    fixed |= {"fixed_link": np.array(robot.base_link), "gravity": -9.81 * up_in_base(hanging)}
    found = [estimated(a, tmp_path, "--support", "pole") for a in (given, fixed)]
    for each in found:
        assert each["valid_residual_classical"].all()
        assert not each["valid_residual_internal"].any()
        assert abs(each["residual_classical"][: PUSHED - 1]).max() < 0.05
        assert abs(each["residual_classical"][SETTLED:]).max() > 1.0
    difference = found[0]["residual_classical"] - found[1]["residual_classical"]
    assert abs(difference).max() < 1e-6
    by_imu = estimated(hanging.arrays, tmp_path, "--support", "pole")["residual_classical"]
    assert 0.0 < abs(by_imu - found[0]["residual_classical"]).max() < 0.5  # it starts swinging


def test_without_a_sensor_what_depends_on_it_is_invalid(standing, tmp_path, capsys):
    found = estimated(without(standing.arrays, "ft_l_arm_ft"), tmp_path)
    assert "no ft_l_arm_ft" in capsys.readouterr().err
    assert not found["valid_wrench_l_hand_dh_frame"].any()
    assert not found["wrench_l_hand_dh_frame"].any()
    assert found["valid_wrench_r_hand_dh_frame"].all()
    names = found["joint_names"].tolist()
    assert not found["valid_joint_torque"][:, names.index("l_elbow")].any()
    assert found["valid_joint_torque"][:, names.index("r_elbow")].all()


def test_a_tare_takes_biases_off(robot, standing, tmp_path, capsys):
    rest = {
        name: array if name == "stamp" else np.repeat(array[:1], 400, axis=0)
        for name, array in standing.arrays.items()
    }
    for name in ("dq", "ddq", "imu_gyro", "imu_dgyro"):
        rest[name] = np.zeros_like(rest[name])
    rest["imu_acc"] = rest["imu_acc"] * 9.81 / np.linalg.norm(rest["imu_acc"][0])
    biased = rest | {"ft_l_arm_ft": rest["ft_l_arm_ft"] + [3.0, 0.0, 0.0, 0.0, 0.1, 0.0]}
    plain = estimated(biased, tmp_path)
    tared = estimated(biased, tmp_path, "--tare", "0.2")
    assert "tared: l_arm_ft" in capsys.readouterr().err
    assert np.linalg.norm(plain["wrench_l_hand_dh_frame"][-1, :3]) > 2.5
    assert np.linalg.norm(tared["wrench_l_hand_dh_frame"][-1, :3]) < 0.1
    assert plain["contact_link"][-1, 0] and not tared["contact_link"][-1, 0]


def test_a_saturated_sensor_costs_its_limb_and_is_told(robot, standing, tmp_path, capsys):
    sensor = robot.ft_sensors.index("l_arm_ft")
    arrays = dict(standing.arrays)
    arrays["ft_l_arm_ft"] = arrays["ft_l_arm_ft"].copy()
    arrays["ft_l_arm_ft"][200:210, 0] = robot.ft_range[sensor, 0]
    found = estimated(arrays, tmp_path)
    assert "l_arm_ft: saturated in 10 samples" in capsys.readouterr().err
    valid = found["valid_wrench_l_hand_dh_frame"].all(axis=1)
    assert np.flatnonzero(~valid).tolist() == list(range(200, 210))
    assert found["valid_wrench_r_hand_dh_frame"].all()


def test_a_limb_that_nothing_touches_has_no_wrench(standing, tmp_path):
    found = estimated(standing.arrays, tmp_path, "--contact", f"{LINK}:none")
    assert "wrench_l_hand_dh_frame" not in found and f"wrench_{LINK}" not in found
    assert "wrench_r_hand_dh_frame" in found


@pytest.mark.parametrize("kind", ["force", f"direction={','.join(str(-f) for f in FORCE)}"])
def test_what_is_known_of_a_push_tells_it_from_a_second_contact(kind, standing, tmp_path):
    """The second one is on the same frame, and has a name of its own."""
    contacts = ("--contact", f"{TOUCH}:{kind}", "--contact", f"{LINK}:0.01,0.02,0:direction=1,0,0")
    found = estimated(standing.arrays, tmp_path, *contacts)
    assert abs(found[f"wrench_{LINK}"][PUSHED:, :3] - FORCE).max() < 1e-6
    assert abs(found[f"wrench_{LINK}_2"]).max() < 1e-6
    assert abs(found["joint_torque"] - standing.true("link_torque")).max() < 1e-6


def test_the_progress_bar_tells_share_and_speed():
    bar = ProgressBar(size=200, period=1e-3)
    assert bar.text(100, elapsed=0.005) == f"[{15 * '#'}{15 * '-'}] 50 %  20.0 x real time"
