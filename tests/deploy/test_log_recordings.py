"""``wrenchbus log info`` and ``export``."""

import csv
import json
import struct

import numpy as np
import pytest

from bus.recording import Recording, RecordingWriter
from deploy.main import run
from robot_model import load_robot
from tests.deploy.recorded import FRAMES, LATENCY, START, TICK, make_recording


@pytest.fixture(scope="module")
def robot():
    return load_robot("icub")


@pytest.fixture(scope="module")
def recording(robot, tmp_path_factory):
    return make_recording(tmp_path_factory.mktemp("recording") / "touch.mcap", robot)


def test_info_tells_duration_ports_losses_attachments_and_metadata(recording, capsys):
    assert run(["log", "info", str(recording), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    ports = {port["name"]: port for port in told["ports"]}
    assert ports["/icub/torques:o"]["messages"] == FRAMES
    assert ports["/icub/torques:o"]["type"] == "JointTorques/1"
    assert told["lost"] == 0 and told["duration_s"] == pytest.approx(0.08, abs=0.03)
    assert {entry["name"] for entry in told["attachments"]} == {
        "robot/icub.yaml",
        "robot/icub.urdf",
    }
    assert told["metadata"]["recording"]["version"] == "test"


def test_info_for_people_is_a_table_of_ports(recording, capsys):
    assert run(["log", "info", str(recording)]) == 0
    shown = capsys.readouterr().out
    assert "/icub/sensors:o" in shown and "SensorFrame/1" in shown and "0 lost" in shown


def test_arrays_of_all_ports_are_those_that_were_written(recording, robot, tmp_path, capsys):
    out = tmp_path / "all.npz"
    assert run(["log", "export", str(recording), "-o", str(out)]) == 0
    arrays = np.load(out)
    assert arrays["icub/torques:o/torque"].shape == (FRAMES, robot.n)
    assert (arrays["icub/torques:o/torque"] == np.arange(robot.n)).all()
    assert arrays["icub/torques:o/valid"].shape == (FRAMES, robot.n)
    assert arrays["icub/torques:o/message_valid"].all()
    assert (arrays["icub/sensors:o/stamp"] == TICK * np.arange(FRAMES)).all()
    assert (arrays["icub/sensors:o/acquired"] == START + TICK * np.arange(FRAMES)).all()
    assert (arrays["icub/sensors:o/sent"] - arrays["icub/sensors:o/acquired"] == LATENCY).all()
    assert arrays["icub/base:o/covariance"].shape == (FRAMES, 12, 12)
    assert arrays["joint_names"].tolist() == list(robot.joints)
    assert arrays["user/note:o/text"].tolist() == ["half"]
    assert json.loads(str(arrays["icub/contacts:o/flags"][0]))[0]["limb"] == "l_arm"


def test_arrays_whose_shape_changes_are_filled_up_with_nan(recording, tmp_path):
    out = tmp_path / "wrenches.npz"
    assert run(["log", "export", str(recording), "/icub/wrenches:o", "-o", str(out)]) == 0
    wrench = np.load(out)["icub/wrenches:o/wrench"]
    assert wrench.shape == (FRAMES, 2, 6)
    assert np.isnan(wrench[:50, 1]).all() and (wrench[50:, 1, 1] == 10.0).all()


def test_a_range_of_time_counts_from_the_start(recording, tmp_path):
    out = tmp_path / "part.npz"
    arguments = ["log", "export", str(recording), "/icub/base:o", "-o", str(out)]
    assert run([*arguments, "--from", "0.02", "--to", "0.06"]) == 0
    assert len(np.load(out)["icub/base:o/stamp"]) == 40


def test_tables_name_joint_and_unit_in_their_header(recording, robot, tmp_path):
    out = tmp_path / "tables"
    assert run(["log", "export", str(recording), "-o", str(out)]) == 0
    with (out / "icub_sensors_o.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == FRAMES
    assert float(rows[7]["q.l_elbow [rad]"]) == 0.01 * robot.joints.index("l_elbow")
    assert float(rows[0]["ft.l_arm_ft.fz [N]"]) == 2.0
    assert float(rows[0]["ft.l_arm_ft.mx [N m]"]) == 3.0
    assert rows[3]["stamp [ns]"] == str(3 * TICK)
    assert rows[0]["joint_valid.l_elbow"] == "1"


def test_a_contact_that_comes_later_has_its_columns(recording, tmp_path):
    out = tmp_path / "tables"
    assert run(["log", "export", str(recording), "/icub/wrenches:o", "-o", str(out)]) == 0
    with (out / "icub_wrenches_o.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert rows[0]["wrench.l_hand_dh_frame.fy [N]"] == ""
    assert float(rows[99]["wrench.l_hand_dh_frame.fy [N]"]) == 10.0
    assert "subtree_wrench.l_arm.fx [N]" in rows[0]


def changed_copy(recording, path, port, by):
    """Copy a recording; the last number of a port's last message is larger."""
    source, writer = Recording(recording), RecordingWriter(path, {})
    channels = {
        name: writer.open_channel(name, {"type": each.type, "fields": each.fields})
        for name, each in source.ports.items()
    }
    messages = list(source.messages())
    last = max(k for k, message in enumerate(messages) if message.port == port)
    for k, message in enumerate(messages):
        data = message.data
        if k == last:
            (number,) = struct.unpack("<d", data[-8:])
            data = data[:-8] + struct.pack("<d", number + by)
        writer.write(channels[message.port], data, message.envelope, message.arrival)
    writer.close()


def test_two_recordings_are_compared_port_by_port(recording, tmp_path, capsys):
    port, other = "/icub/torques:o", tmp_path / "other.mcap"
    assert run(["log", "diff", str(recording), str(recording)]) == 0
    assert port in capsys.readouterr().out
    changed_copy(recording, other, port, by=0.25)
    assert run(["log", "diff", str(recording), str(other), "--json"]) == 1
    rows = {row["port"]: row for row in json.loads(capsys.readouterr().out)}
    assert rows[port]["differing"] == 1 and rows[port]["largest"] == pytest.approx(0.25)
    assert rows["/icub/sensors:o"]["differing"] == 0
    assert run(["log", "diff", str(recording), str(other), "/icub/sensors:o"]) == 0


@pytest.mark.parametrize(
    ("arguments", "status", "expected"),
    [
        (["info", "no_such.mcap"], 1, "no_such.mcap"),
        (["export", "{file}", "/icub/torque:o", "-o", "{out}.npz"], 2, "/icub/torques:o"),
        (["export", "{file}", "-o", "."], 2, "--force replaces it"),
        (["export", "{file}", "-o", "{file}", "--force"], 2, "is the input"),
        (["convert", "{file}", "-o", "{file}", "--force"], 2, "is the input"),
        (["export", "{file}", "--from", "3", "--to", "2", "-o", "{out}"], 2, "--from before --to"),
        (["export", "{file}"], 2, "-o"),
        (["convert", "{file}", "-o", "/no/such/folder/x.mcap"], 1, "/no/such/folder"),
    ],
)
def test_mistakes_are_one_line(arguments, status, expected, recording, tmp_path, capsys):
    filled = [a.format(file=recording, out=tmp_path / "out") for a in arguments]
    assert run(["log", *filled]) == status
    shown = capsys.readouterr().err
    assert expected in shown and shown.count("\n") == 1


def test_log_without_a_verb_on_recordings_is_the_services_log(runtime_directory, capsys):
    assert run(["log", "torque_observer"]) == 1
    assert "no bus is running" in capsys.readouterr().err


@pytest.mark.parametrize(
    "verb", ["info", "diff", "export", "convert", "import-yarp", "import-csv", "import-npz"]
)
def test_help_of_every_verb_on_recordings_ends_with_an_example(verb, capsys):
    assert run(["log", verb, "--help"]) == 0
    assert f"Example: wrenchbus log {verb}" in capsys.readouterr().out
