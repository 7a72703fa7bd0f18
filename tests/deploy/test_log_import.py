"""``wrenchbus log import-yarp``, ``import-csv`` and ``import-npz``."""

import json

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from bus.decoder import Decoder
from bus.recording import Recording
from deploy.main import run
from deploy.recordings.foreign.bottle import BottleError, parse
from deploy.recordings.foreign.samples import rising
from deploy.recordings.robots import robots_of
from robot_model import load_robot
from robot_model.ft_convention import raw_to_wrenchbus
from robot_model.messages import RawFrame
from tests.deploy.yarp_dump import MAP, START, write_dump

TEXT = MAP.read_text().replace("grid: 1000", "grid: fastest")

BOTTLES = [
    ("1 -2.5 +3 1e-3 .5", [1, -2.5, 3, 1e-3, 0.5]),
    ("(1 2 (3)) [ok] 4", [[1, 2, [3]], "ok", 4]),
    ('"a b" c "say \\"hi\\"" "" "line\\nend"', ["a b", "c", 'say "hi"', "", "line\nend"]),
    ("0x1f 0X10 -0x1", [31, 16, -1]),
    ("true false null", [True, False, None]),
    ("{0 255 16}", [b"\x00\xff\x10"]),
    ("1, 2,3", [1, 2, 3]),
    ("left-arm 1.2.3 e5 in", ["left-arm", "1.2.3", "e5", "in"]),
    ("()", [[]]),
    ("", []),
]


@pytest.fixture(scope="module")
def robot():
    return load_robot("icub")


@pytest.fixture
def dump(tmp_path):
    return write_dump(tmp_path / "dump")


@pytest.fixture
def fastest(tmp_path):
    """The map of docs/, on the log's own instants."""
    path = tmp_path / "fastest.yaml"
    path.write_text(TEXT)
    return path


def convert(capsys, *arguments):
    """Import and return the summary and what was said on standard error."""
    status = run(["log", *map(str, arguments), "--json"])
    shown = capsys.readouterr()
    assert status == 0, shown.err
    return json.loads(shown.out), shown.err


def frames(path, robot):
    """Return stamps since the first [s] and the raw frames, as a driver would read them."""
    decoder = Decoder(RawFrame, robot.model_hash, robot.dimensions)
    read = [decoder.decode(m.data) for m in Recording(path).messages(["/icub/raw:o"])]
    stamps = np.array([envelope.stamp for _, envelope in read])
    return stamps * 1e-9 - START, [frame for frame, _ in read]


@pytest.mark.parametrize(("text", "expected"), BOTTLES)
def test_a_bottle_is_read_as_yarp_writes_it(text, expected):
    assert parse(text) == expected


@pytest.mark.parametrize("text", ["(1 2", "1)", '"open', "[ok", "{300}", "(" * 100])
def test_a_bottle_that_does_not_close_is_an_error(text):
    with pytest.raises(BottleError):
        parse(text)


@given(st.text(alphabet='01.-+xeinf(){}[]"\\ ,a\n', max_size=60))
def test_any_text_is_a_bottle_or_an_error(text):
    try:
        parse(text)
    except BottleError:
        pass


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


TABLE_MAP = {
    "time": {"column": "time", "unit": "ms"},
    "streams": [
        {"columns": ["elbow"], "q": {"joints": ["l_elbow"], "unit": "rad"}},
        {
            "columns": ["fx", "fy", "fz", "mx", "my", "mz"],
            "ft": {"sensor": "l_arm_ft", "convention": "wrenchbus"},
        },
    ],
}


def write_table(tmp_path, rows):
    table, chosen = tmp_path / "log.csv", tmp_path / "map.yaml"
    table.write_text("time,elbow,fx,fy,fz,mx,my,mz\n" + "\n".join(rows) + "\n")
    chosen.write_text(yaml.safe_dump(TABLE_MAP))
    return table, chosen


def test_a_table_is_imported_and_empty_cells_are_no_samples(robot, tmp_path, capsys):
    rows = [f"{10 * k},{0.1 * k},{k},0,0,0,0,0" for k in range(20)]
    rows[5] = "50,0.5,,,,,,"  # bridged
    rows[7] = "70,zero,7,0,0,0,0,0"
    rows[9] = "90"
    table, chosen = write_table(tmp_path, rows)
    out = tmp_path / "out.mcap"
    summary, said = convert(capsys, "import-csv", table, "--map", chosen, "-o", out)
    assert f"{table}:9: malformed" in said and f"{table}:11: malformed" in said
    assert summary["lines_left_out"] == 3  # the last one in each of the two streams
    t, read = frames(out, robot)
    elbow, arm = robot.joints.index("l_elbow"), robot.ft_sensors.index("l_arm_ft")
    assert len(read) == 18
    assert read[5].q[elbow] == pytest.approx(0.5) and read[5].ft[arm, 0] == pytest.approx(5.0)


def make_arrays(robot, samples=50):
    return {
        "stamp": 10**9 + 1_000_000 * np.arange(samples),
        "joint_names": np.array(robot.joints[::-1]),
        "q": np.tile(0.01 * np.arange(robot.n)[::-1], (samples, 1)),
        "ft_l_arm_ft": np.ones((samples, 6)),
        "imu_gyro": np.zeros((samples, 3)),
        "imu_acc": np.full((samples, 3), 9.81),
    }


def test_arrays_are_imported_in_the_robots_order(robot, tmp_path, capsys):
    arrays = make_arrays(robot)
    arrays["ft_l_arm_ft"][7, 2] = np.nan
    np.savez(tmp_path / "log.npz", **arrays)
    out = tmp_path / "out.mcap"
    _, said = convert(capsys, "import-npz", tmp_path / "log.npz", "-o", out)
    assert "not a finite number" in said and "ft: never valid: r_arm_ft" in said
    _, read = frames(out, robot)
    assert read[3].q.tolist() == (0.01 * np.arange(robot.n)).tolist()
    assert read[3].imu_valid.all() and read[3].ft[0].tolist() == 6 * [1.0]
    assert read[7].ft_valid[0]  # one sample is bridged


def test_measured_velocities_and_torques_are_kept(robot, tmp_path, capsys):
    arrays = make_arrays(robot)
    shape = arrays["q"].shape
    arrays |= {"dq": np.full(shape, 0.5), "motor_torque": np.full(shape, 2.0)}
    np.savez(tmp_path / "log.npz", **arrays)
    out = tmp_path / "out.mcap"
    convert(capsys, "import-npz", tmp_path / "log.npz", "-o", out)
    _, read = frames(out, robot)
    assert read[3].dq.tolist() == robot.n * [0.5]
    assert read[3].motor_torque.tolist() == robot.n * [2.0]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"stamp": None}, "no array 'stamp'"),
        ({"stamp": np.arange(50.0)}, "stamp: expected (T,) integers [ns], got float64"),
        ({"stamp": np.zeros(50, dtype=int)}, "stamp: expected rising"),
        ({"q": np.zeros((50, 3))}, "q: expected (50, 32) numbers"),
        ({"ft_l_arm": np.zeros((50, 6))}, "did you mean l_arm_ft"),
        ({"joint_names": np.array(["elbow"] * 32)}, "has no joint elbow"),
    ],
)
def test_arrays_that_do_not_fit_are_one_line(change, expected, robot, tmp_path, capsys):
    arrays = make_arrays(robot) | change
    kept = {name: array for name, array in arrays.items() if array is not None}
    np.savez(tmp_path / "log.npz", **kept)
    path, out = str(tmp_path / "log.npz"), tmp_path / "out.mcap"
    assert run(["log", "import-npz", path, "-o", str(out)]) == 2
    shown = capsys.readouterr().err
    assert expected in shown and shown.count("\n") == 1 and not out.exists()


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
