"""``wrenchbus log import-yarp``: what a dump says."""

import json

import numpy as np
import pytest
import yaml

from bus.recording import Recording
from deploy.recordings.robots import robots_of
from robot_model.ft_convention import raw_to_wrenchbus
from tests.deploy.foreign_logs.importing import TEXT, convert, frames, make_arrays
from tests.deploy.yarp_dump import MAP, START, write_dump


def test_joint_positions_are_radians_in_the_robots_order(dump, robot, tmp_path, capsys, fastest):
    out = tmp_path / "out.mcap"
    summary, said = convert(capsys, "import-yarp", dump, "--map", fastest, "-o", out)
    assert summary["frames"] == 101 and summary["hz"] == pytest.approx(100.0)
    assert summary["lines_left_out"] == 0
    assert said.count("\n") == 1 and "100 Hz: the sensor server's window" in said
    t, read = frames(out, robot)
    assert t == pytest.approx(np.arange(101) * 0.01, abs=1e-6)
    for name, place in (("torso_yaw", 0), ("torso_pitch", 2), ("l_wrist_yaw", 6), ("r_knee", 3)):
        row = robot.joints.index(name)
        assert read[37].q[row] == pytest.approx(np.radians(5.0 * place + 0.37), abs=1e-7)
    assert all(frame.joint_valid.all() for frame in read)
    assert read[0].dq is None


def test_readings_are_interpolated_and_turned_into_our_convention(
    dump, robot, tmp_path, capsys, fastest
):
    out = tmp_path / "out.mcap"
    convert(capsys, "import-yarp", dump, "--map", fastest, "-o", out)
    _, read = frames(out, robot)
    for row in range(len(robot.ft_sensors)):
        expected = raw_to_wrenchbus(robot)[row] @ (np.arange(6.0) + 0.5)
        assert read[50].ft[row] == pytest.approx(expected, abs=1e-5)
    assert not read[0].ft_valid.any() and not read[0].ft.any()  # their first sample came later
    assert read[1].ft_valid.all()
    assert read[50].imu_gyro[0] == pytest.approx([np.radians(4.5), 0.0, 0.0], abs=1e-6)
    assert read[50].imu_acc[0] == pytest.approx([0.0, 0.0, 9.81])


def test_the_recording_says_how_it_was_made_and_bears_its_robot(
    dump, robot, tmp_path, capsys, fastest
):
    out = tmp_path / "out.mcap"
    convert(capsys, "import-yarp", dump, "--map", fastest, "-o", out)
    recording = Recording(out)
    about = recording.metadata["recording"]
    assert about["interpolation"] == "linear; gaps of more than 5 periods are invalid"
    assert "fastest" in about["grid"]
    assert json.loads(about["force_torque"])["l_arm_ft"] == "urdf"
    assert robots_of(recording)[robot.model_hash].joints == robot.joints
    assert recording.ports["/icub/raw:o"].type == "RawFrame/1"


@pytest.mark.parametrize(("which", "delay"), [("sent", 0.0), ("received", 0.5)])
def test_of_two_stamps_the_map_names_one(which, delay, robot, tmp_path, capsys):
    dump = write_dump(tmp_path / "dump", stamp="Stamp: tx+rx;\n")
    chosen = tmp_path / "map.yaml"
    chosen.write_text(TEXT.replace("stamps: sent", f"stamps: {which}"))
    out = tmp_path / "out.mcap"
    convert(capsys, "import-yarp", dump, "--map", chosen, "-o", out)
    t, read = frames(out, robot)
    assert t[0] == pytest.approx(delay, abs=1e-6)
    assert read[10].q[robot.joints.index("torso_yaw")] == pytest.approx(np.radians(0.1), abs=1e-7)


def test_two_stamps_are_seen_where_info_log_is_silent(robot, tmp_path, capsys, fastest):
    dump = write_dump(tmp_path / "dump", stamp="Stamp: tx+rx;\n")
    for info in dump.rglob("info.log"):
        info.write_text(info.read_text().replace("Stamp: tx+rx;\n", ""))
    summary, _ = convert(capsys, "import-yarp", dump, "--map", fastest, "-o", tmp_path / "out.mcap")
    assert summary["lines_left_out"] == 0 and summary["frames"] == 101


def test_a_gap_is_invalid_and_not_bridged(dump, robot, tmp_path, capsys, fastest):
    file = dump / "icub_left_arm_analog_o" / "data.log"
    lines = file.read_text().splitlines()
    file.write_text("\n".join(lines[:30] + lines[60:]))
    out = tmp_path / "out.mcap"
    convert(capsys, "import-yarp", dump, "--map", fastest, "-o", out)
    _, read = frames(out, robot)
    arm = robot.ft_sensors.index("l_arm_ft")
    assert not any(frame.ft_valid[arm] for frame in read[31:60])
    assert not any(frame.ft[arm].any() for frame in read[31:60])
    assert read[29].ft_valid[arm] and read[62].ft_valid[arm]
    assert read[45].ft_valid.sum() == len(robot.ft_sensors) - 1


def test_the_map_for_icub_is_fine_enough_for_the_sensor_server(dump, tmp_path, capsys):
    out = tmp_path / "out.mcap"
    summary, said = convert(capsys, "import-yarp", dump, "--map", MAP, "-o", out)
    assert summary["frames"] == 1001 and said == ""


def test_arrays_are_brought_to_a_grid(robot, tmp_path, capsys):
    np.savez(tmp_path / "log.npz", **make_arrays(robot))
    out = tmp_path / "out.mcap"
    path = tmp_path / "log.npz"
    summary, _ = convert(capsys, "import-npz", path, "--grid", 500, "-o", out)
    assert summary["frames"] == 25 and summary["hz"] == 500.0


def test_a_stated_grid_is_kept(dump, robot, tmp_path, capsys):
    chosen = tmp_path / "map.yaml"
    chosen.write_text(TEXT.replace("grid: fastest", "grid: 250"))
    out = tmp_path / "out.mcap"
    summary, _ = convert(capsys, "import-yarp", dump, "--map", chosen, "-o", out)
    assert summary["frames"] == 251
    t, read = frames(out, robot)
    assert t[1] - t[0] == pytest.approx(0.004, abs=1e-6)
    yaw = robot.joints.index("torso_yaw")
    assert read[1].q[yaw] == pytest.approx(np.radians(0.004), abs=1e-7)
    assert Recording(out).metadata["recording"]["grid"].startswith("250 Hz")


def test_numbers_inside_nested_lists_are_found(robot, tmp_path, capsys):
    folder = tmp_path / "dump" / "state"
    folder.mkdir(parents=True)
    rows = [f'{k} {START + 0.01 * k} ((1.0 {k}.0) [ok]) "x"' for k in range(10)]
    (folder / "data.log").write_text("\n".join(rows))
    chosen = tmp_path / "map.yaml"
    q = {"unit": "deg", "joints": [None, "l_elbow"]}
    stream = {"source": "state", "inside": [0, 0], "q": q}
    chosen.write_text(yaml.safe_dump({"streams": [stream]}))
    out = tmp_path / "out.mcap"
    convert(capsys, "import-yarp", tmp_path / "dump", "--map", chosen, "-o", out)
    _, read = frames(out, robot)
    assert read[7].q[robot.joints.index("l_elbow")] == pytest.approx(np.radians(7.0))
