"""What ``wrenchbus estimate`` refuses, and how it says so."""

from pathlib import Path

import numpy as np
import pytest

from deploy.contacts import read_touch
from deploy.errors import UsageError
from deploy.estimate.reading import read_input
from deploy.main import run
from robot_model import Robot, load_robot

SIZE = 60


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("icub")


def resting(robot: Robot) -> dict[str, np.ndarray]:
    """Return a complete log of a robot that hangs still."""
    arrays = {"stamp": 1_000_000 * np.arange(SIZE), "q": np.tile(robot.home, (SIZE, 1))}
    arrays |= {f"ft_{sensor}": np.zeros((SIZE, 6)) for sensor in robot.ft_sensors}
    arrays |= {"imu_gyro": np.zeros((SIZE, 3)), "imu_acc": np.tile([0.0, 0.0, 9.81], (SIZE, 1))}
    return arrays


def with_nan(size: int, width: int, row: int, column: int) -> np.ndarray:
    values = np.zeros((size, width))
    values[row, column] = np.nan
    return values


SWAPPED = 1_000_000 * np.arange(SIZE)
SWAPPED[[20, 21]] = SWAPPED[[21, 20]]
MOVING = np.tile(np.linspace(0.0, 0.3, SIZE)[:, None], (1, 32)) * np.eye(32)[3]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"q": None}, "no array 'q'; it has stamp"),
        ({"stamp": None}, "no array 'stamp'; it has q"),
        ({"imu_acc": None}, "no array 'imu_acc', and no 'fixed_link' in its place"),
        ({"imu_gyr": np.zeros((SIZE, 3))}, "imu_gyr: no array of this name is known; did you mean"),
        ({"ft_l_arm": np.zeros((SIZE, 6))}, "did you mean 'ft_l_arm_ft'?"),
        ({"q": np.zeros((SIZE, 31))}, "q: expected (60, 32) numbers, got float64 (60, 31)"),
        ({"ft_l_arm_ft": np.zeros((SIZE, 3))}, "ft_l_arm_ft: expected (60, 6) numbers"),
        ({"motor_torque": np.zeros((59, 32))}, "motor_torque: expected (60, 32)"),
        ({"imu_dgyro": np.array(["fast"] * SIZE)}, "imu_dgyro: expected (60, 3) numbers, got <U4"),
        ({"stamp": SWAPPED}, "stamp: expected rising, got 20000000 after 21000000 at index 21"),
        ({"stamp": np.arange(SIZE) * 1e-3}, "stamp: expected (T,) integers [ns], got float64"),
        ({"stamp": 1000 * np.arange(SIZE)}, "stamp: expected ns, got steps that mean 1e+06 Hz"),
        ({"q": with_nan(SIZE, 32, 7, 9)}, "got nan at index 7, l_elbow (1 of 60 samples)"),
        ({"ft_r_arm_ft": with_nan(SIZE, 6, 3, 4)}, "ft_r_arm_ft: expected finite numbers"),
        ({"q": np.full((SIZE, 32), 30.0)}, "are these degrees?"),
        ({"imu_gyro": np.full((SIZE, 3), 90.0)}, "imu_gyro: up to 90 rad/s: are these degrees?"),
        ({"q": MOVING, "dq": np.degrees(np.gradient(MOVING, 1e-3, axis=0))}, "dq: 57.3 times"),
        ({"imu_acc": np.tile([0, 0, 1.0], (SIZE, 1))}, "multiples of g"),
        ({"joint_names": np.array(["elbow"] * 32)}, "icub has no joint elbow; did you mean"),
        ({"joint_names": np.array(["l_elbow"] * 32)}, "l_elbow is there twice"),
        ({"joint_names": np.array(["l_elbow"])}, "expected all 32 joints of icub, got 1, without"),
        ({"fixed_link": np.array("root_lnk")}, "fixed_link: icub has no frame 'root_lnk'; did you"),
        ({"fixed_link": np.array(3)}, "fixed_link: expected the name of a link, got int64"),
        ({"gravity": np.zeros(3)}, "gravity: expected together with fixed_link"),
        ({"fixed_link": np.array("chest"), "gravity": np.zeros(2)}, "gravity: expected (3,)"),
        ({"base_quat_wxyz": np.ones((SIZE, 4))}, "base_quat_wxyz: expected length 1, got 2"),
        ({"base_quat_wxyz": np.ones((SIZE, 3))}, "base_quat_wxyz: expected (60, 4)"),
    ],
)
def test_arrays_that_do_not_fit_are_named(change, expected, robot, tmp_path):
    arrays = {k: v for k, v in (resting(robot) | change).items() if v is not None}
    source = tmp_path / "log.npz"
    np.savez(source, allow_pickle=False, **arrays)
    with pytest.raises(UsageError) as error:
        read_input(source, robot)
    assert expected in str(error.value) and str(source) in str(error.value)


def test_a_mistake_is_one_line_and_status_2(robot, tmp_path, capsys):
    source, out = tmp_path / "log.npz", tmp_path / "out.npz"
    np.savez(source, allow_pickle=False, **resting(robot) | {"ft_l_arm": np.zeros((SIZE, 6))})
    assert run(["estimate", str(source), "-o", str(out)]) == 2
    shown = capsys.readouterr()
    assert shown.err.count("\n") == 1 and shown.out == "" and not out.exists()


@pytest.mark.parametrize(
    ("arguments", "status", "expected"),
    [
        (["--robot", "icup"], 2, "did you mean 'icub'?"),
        (["--support", "flor"], 2, "no support 'flor'"),
        (["--contact", "l_forerm"], 2, "did you mean 'l_forearm'?"),
        (["--contact", "l_foot:none"], 2, "touched at 'l_sole'"),
        (["--contact", "l_forearm:forse"], 2, "expected FRAME[:X,Y,Z]"),
        (["--tare", "0.5"], 2, "expected less than the log's 0.059 s"),
        (["--tare", "0.01"], 1, "not tared"),
        (["--tare", "-1"], 2, "--tare"),
    ],
)
def test_wishes_that_make_no_sense_are_one_line(
    arguments, status, expected, robot, tmp_path, capsys
):
    source, out = tmp_path / "log.npz", tmp_path / "out.npz"
    np.savez(source, allow_pickle=False, **resting(robot))
    assert run(["estimate", str(source), "-o", str(out), *arguments]) == status
    shown = capsys.readouterr().err
    assert expected in shown and shown.count("\n") == 1 and not out.exists()


def test_too_few_samples_to_estimate_motion_are_told(robot, tmp_path, capsys):
    source = tmp_path / "log.npz"
    short = {name: array[:30] for name, array in resting(robot).items()}
    np.savez(source, allow_pickle=False, **short)
    assert run(["estimate", str(source), "-o", str(tmp_path / "out.npz")]) == 2
    assert "30 samples are too few to estimate motion: expected 49" in capsys.readouterr().err


def test_gaps_are_warned_of(robot, tmp_path, capsys):
    source, arrays = tmp_path / "log.npz", resting(robot)
    arrays["stamp"][30:] += 100_000_000
    np.savez(source, allow_pickle=False, **arrays)
    assert run(["estimate", str(source), "-o", str(tmp_path / "out.npz")]) == 0
    assert "1 gaps or odd steps of the stamps, first at index 30" in capsys.readouterr().err


def test_without_meshes_there_are_torques_but_no_contacts(tmp_path, capsys):
    file = Path(__file__).parents[1] / "robot_model" / "data" / "arm.yaml"
    arm, source, out = load_robot(file), tmp_path / "log.npz", tmp_path / "out.npz"
    still = np.zeros((SIZE, arm.n))
    arrays = {"stamp": 1_000_000 * np.arange(SIZE), "q": still, "motor_torque": still}
    arrays |= {f"ft_{sensor}": np.zeros((SIZE, 6)) for sensor in arm.ft_sensors}
    np.savez(source, allow_pickle=False, **arrays, fixed_link=np.array(arm.base_link))
    assert run(["estimate", "--robot", str(file), str(source), "-o", str(out)]) == 0
    assert "no residuals and contacts" in capsys.readouterr().err
    with np.load(out) as found:
        assert found["valid_joint_torque"].any() and "residual_internal" not in found.files


def test_files_that_are_no_logs_are_one_line(tmp_path, capsys):
    text, out = tmp_path / "log.csv", tmp_path / "out.npz"
    text.write_text("time,q\n")
    broken = tmp_path / "broken.npz"
    broken.write_bytes(b"PK\x03\x04nothing")
    for source, status in ((text, 1), (broken, 2), (tmp_path / "absent.npz", 2)):
        assert run(["estimate", str(source), "-o", str(out)]) == status
        shown = capsys.readouterr().err
        assert source.name in shown and shown.count("\n") == 1


def test_the_input_is_never_written_over(robot, tmp_path, capsys):
    source = tmp_path / "log.npz"
    np.savez(source, allow_pickle=False, **resting(robot))
    before = source.read_bytes()
    assert run(["estimate", str(source), "-o", str(source)]) == 2
    assert "is the input" in capsys.readouterr().err and source.read_bytes() == before
    assert run(["estimate", str(source), "-o", str(tmp_path / "no" / "out.npz")]) == 1
    assert "there is no folder" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("chest", ("chest", [0, 0, 0], "wrench", None)),
        ("chest:1,2,-3", ("chest", [1, 2, -3], "wrench", None)),
        ("chest:force", ("chest", [0, 0, 0], "force", None)),
        ("chest:1,2,3:none", ("chest", [1, 2, 3], "none", None)),
        ("chest:direction=0,0,1", ("chest", [0, 0, 0], "direction", [0, 0, 1])),
        ("chest:.1,0,0:direction=1,0,0", ("chest", [0.1, 0, 0], "direction", [1, 0, 0])),
    ],
)
def test_a_contact_is_read_as_it_is_typed(text, expected):
    touch = read_touch(text)
    frame, point, unknown, vector = expected
    assert (touch.frame, touch.point.tolist(), touch.unknown) == (frame, point, unknown)
    assert touch.vector is None if vector is None else touch.vector.tolist() == vector


@pytest.mark.parametrize(
    "text",
    ["", ":1,2,3", "a:1,2", "a:1,2,x", "a:nan,0,0", "a:push", "a:direction=0,0,0",
     "a:direction=1", "a:known", "a:wrench:1,2,3", "a:1,2,3:force:none"],
)  # fmt: skip
def test_another_form_of_a_contact_is_refused(text):
    with pytest.raises(UsageError, match="^contact: expected"):
        read_touch(text)
