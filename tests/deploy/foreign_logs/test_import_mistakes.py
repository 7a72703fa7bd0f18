"""Dumps and maps that are spoilt, doubtful or do not fit."""

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from bus.recording import Recording
from deploy.main import run
from deploy.recordings.foreign.samples import rising
from tests.deploy.foreign_logs.importing import TEXT, convert, frames, make_arrays


def test_malformed_lines_are_counted_and_named_and_cost_nothing_else(
    dump, tmp_path, capsys, fastest
):
    file = dump / "icub_torso_state_o" / "data.log"
    lines = file.read_text().splitlines()
    lines[3] = "garbage"
    lines[10] = "17 1600000000.1 1.0 (2.0"
    lines[20] = "27 1600000000.2 1.0"
    lines[30] = "37 99999999999.0 1.0 2.0 3.0"
    lines[40] = "47 1600000000.4 1.0 nan 3.0"
    lines[50] = "57 1600000000.5 1.0 text 3.0"
    file.write_bytes("\n".join(lines).encode() + b"\n\xff\xfe\x00")
    out = tmp_path / "out.mcap"
    summary, said = convert(capsys, "import-yarp", dump, "--map", fastest, "-o", out)
    assert summary["lines_left_out"] == 7 and summary["frames"] == 101
    for number in (4, 11, 21, 31, 41, 51, 102):
        assert f"{file}:{number}: " in said
    assert Recording(out).metadata["recording"]["lines_left_out"] == "7"


@pytest.mark.parametrize("seed", range(12))
def test_spoilt_bytes_are_never_fatal(seed, dump, fastest, tmp_path, capsys):
    random = np.random.default_rng(seed)
    odd = [b"1e300", b"9" * 5000, b"(", b'"', b"\x00", b"\n", b"-1", b"nan", b"inf", b"0x", b"\xff"]
    for file in dump.rglob("*.log"):
        content = bytearray(file.read_bytes())
        for place in random.integers(0, len(content), 20):
            content[place : place + 1] = odd[random.integers(len(odd))]
        file.write_bytes(content)
    out = tmp_path / "out.mcap"
    status = run(["log", "import-yarp", str(dump), "--map", str(fastest), "-o", str(out)])
    shown = capsys.readouterr().err
    assert status in (0, 1, 2) and ("data.log:" in shown or "no stream" in shown)


@given(st.lists(st.integers(0, 20), max_size=12))
def test_times_that_are_kept_rise(times):
    array = np.array(times, dtype=np.int64)
    assert (np.diff(array[rising(array)]) > 0).all()


def test_one_wrong_time_costs_no_others():
    for wrong in (0, 10**9):
        times = np.arange(100, 200)
        times[50] = wrong
        assert rising(times).sum() == 99


def test_degrees_declared_as_radians_are_a_warning_that_names_the_channel(dump, tmp_path, capsys):
    chosen = tmp_path / "map.yaml"
    text = TEXT.replace("q: {unit: deg, joints: [torso_yaw", "q: {joints: [torso_yaw")
    chosen.write_text(text)
    out = tmp_path / "out.mcap"
    _, said = convert(capsys, "import-yarp", dump, "--map", chosen, "-o", out)
    assert "position of torso_roll: 5 to 6 rad" in said and "degrees?" in said
    assert said.count("degrees?") == 2  # torso_pitch too; torso_yaw is near 0 and cannot be told


def test_a_joint_beyond_its_limits_is_named(robot, tmp_path, capsys):
    arrays = make_arrays(robot)
    arrays["q"][:, robot.joints[::-1].index("l_elbow")] = -2.0
    np.savez(tmp_path / "log.npz", **arrays)
    _, said = convert(capsys, "import-npz", tmp_path / "log.npz", "-o", tmp_path / "out.mcap")
    assert "position of l_elbow: -2 to -2 rad" in said
    assert "limits" in said


def test_channels_that_the_log_lacks_are_named_and_may_be_held(dump, robot, tmp_path, capsys):
    content = yaml.safe_load(TEXT)
    content["streams"] = [s for s in content["streams"] if "head" not in s["source"]]
    content["held"] = {"neck_yaw": 0.25}
    chosen = tmp_path / "map.yaml"
    chosen.write_text(yaml.safe_dump(content))
    out = tmp_path / "out.mcap"
    _, said = convert(capsys, "import-yarp", dump, "--map", chosen, "-o", out)
    assert "q: never valid: neck_pitch, neck_roll\n" in said
    _, read = frames(out, robot)
    assert read[5].q[robot.joints.index("neck_yaw")] == 0.25
    assert read[5].joint_valid[robot.joints.index("neck_yaw")]
    assert not read[5].joint_valid[robot.joints.index("neck_roll")]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"robot": "icup"}, "unknown robot"),
        ({"grod": 100}, "grod"),
        ({"grid": -5}, "grid"),
        ({"held": {"l_elbo": 0.0}}, "did you mean l_elbow"),
        ({"streams": [{"source": "x", "q": {"joints": ["neck_yaw"]}}]}, "no stream 'x'"),
        ({"streams": [{"source": "x"}]}, "expected one of q"),
        ({"held": {"torso_yaw": 0.0}}, "q of torso_yaw is given twice"),
    ],
)
def test_a_map_that_does_not_fit_is_one_line(change, expected, dump, tmp_path, capsys):
    chosen, out = tmp_path / "map.yaml", tmp_path / "out.mcap"
    chosen.write_text(yaml.safe_dump(yaml.safe_load(TEXT) | change))
    assert run(["log", "import-yarp", str(dump), "--map", str(chosen), "-o", str(out)]) == 2
    shown = capsys.readouterr().err
    assert expected in shown and shown.count("\n") == 1 and not out.exists()


def test_a_log_without_positions_is_refused(dump, tmp_path, capsys, fastest):
    for file in dump.rglob("data.log"):
        file.write_text("nothing here\n")
    out = tmp_path / "out.mcap"
    assert run(["log", "import-yarp", str(dump), "--map", str(fastest), "-o", str(out)]) == 1
    assert "no joint position could be read" in capsys.readouterr().err
