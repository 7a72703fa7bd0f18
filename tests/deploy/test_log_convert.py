"""``wrenchbus log convert``, checked with the readers of MCAP and JSON schemas."""

import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
from jsonschema import Draft202012Validator
from mcap.reader import make_reader

from deploy.main import run
from robot_model import load_robot
from tests.deploy.recorded import FRAMES, START, TICK, make_recording, sensors

DOCS = Path(__file__).parents[2] / "docs"
SCALARS = {"boolean", "number", "integer", "string"}


@pytest.fixture(scope="module")
def robot():
    return load_robot("icub")


@pytest.fixture(scope="module")
def recording(robot, tmp_path_factory):
    return make_recording(tmp_path_factory.mktemp("recording") / "touch.mcap", robot)


@pytest.fixture(scope="module")
def converted(recording, tmp_path_factory):
    path = tmp_path_factory.mktemp("converted") / "json.mcap"
    assert run(["log", "convert", str(recording), "--json", "-o", str(path)]) == 0
    return path


def read(path):
    with path.open("rb") as file:
        yield from make_reader(file, validate_crcs=True).iter_messages()


def values(path, topic):
    return [json.loads(m.data) for _, channel, m in read(path) if channel.topic == topic]


def test_every_json_message_satisfies_its_schema_and_holds_no_nan(converted):
    def refuse(constant):
        raise AssertionError(constant)

    checks = {}
    for schema, channel, message in read(converted):
        assert channel.message_encoding == "json" and schema.encoding == "jsonschema"
        if schema.id not in checks:
            document = json.loads(schema.data)
            Draft202012Validator.check_schema(document)
            checks[schema.id] = Draft202012Validator(document)
        checks[schema.id].validate(json.loads(message.data, parse_constant=refuse))
    assert len(checks) == 8  # six ports, and two schemas of the scene


def test_schemas_use_no_more_than_foxglove_reads(converted):
    with converted.open("rb") as file:
        schemas = make_reader(file).get_summary().schemas.values()

    def look(schema):
        if schema["type"] == "object":
            for entry in schema["properties"].values():
                look(entry)
        elif schema["type"] == "array":
            assert schema["items"]["type"] != "array"
            look(schema["items"])
        else:
            assert schema["type"] in SCALARS

    for schema in schemas:
        look(json.loads(schema.data))


def test_the_converted_file_is_finished_and_keeps_attachments_and_metadata(converted):
    with converted.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary.statistics.message_count == sum(1 for _ in read(converted))
        assert {item.name for item in reader.iter_attachments()} >= {"robot/icub.urdf"}
        assert {item.name for item in reader.iter_metadata()} >= {"recording"}


def test_messages_are_plotted_at_their_measurement_and_not_in_bundles(converted):
    times = [
        (m.log_time, m.publish_time) for _, c, m in read(converted) if c.topic.endswith("torques:o")
    ]
    assert times == [(START + k * TICK,) * 2 for k in range(FRAMES)]


def test_numbers_are_found_by_the_names_of_joints_sensors_and_axes(converted, robot):
    frame = values(converted, "/icub/sensors:o")[3]
    assert frame["q"]["l_elbow"] == 0.01 * robot.joints.index("l_elbow")
    assert frame["ft"]["l_arm_ft"]["mx"] == 3.0
    assert frame["imu_acc"]["head_imu_0"]["z"] == 9.81
    assert frame["stamp"] == pytest.approx(0.003)
    touch = values(converted, "/icub/contacts:o")[0]
    assert touch["flags"]["l_arm"]["state"] == "contact"
    assert touch["hypotheses"]["0"]["force"]["y"] == 10.0
    assert touch["hypotheses"]["0"]["covariance"]["5"] == 1.0
    assert values(converted, "/icub/base:o")[0]["covariance"]["11"] == 12.0


def test_session_time_is_the_simulated_clock(recording, tmp_path):
    out = tmp_path / "json.mcap"
    arguments = ["log", "convert", str(recording), "/icub/base:o", "-o", str(out)]
    assert run([*arguments, "--session-time", "--rate", "100"]) == 0
    assert [m.log_time for _, _, m in read(out)] == [10 * TICK * k for k in range(10)]


def chain(transforms, frame):
    """Return the position of a frame in the world, and its rotation matrix."""
    pose = pin.SE3.Identity()
    while frame != "world":
        entry = transforms[frame]
        rotation = pin.Quaternion(np.array([entry["rotation"][k] for k in "xyzw"]))
        position = np.array([entry["translation"][k] for k in "xyz"])
        pose = pin.SE3(rotation.matrix(), position) * pose
        frame = entry["parent_frame_id"]
    return pose


def test_transforms_place_the_links_where_forward_kinematics_does(converted, robot):
    static = values(converted, "/icub/3d/static_transforms")[0]["transforms"]
    last = values(converted, "/icub/3d/transforms")[-1]["transforms"]
    named = {entry["child_frame_id"]: entry for entry in static + last}
    stamp = last[0]["timestamp"]
    tick = (stamp["sec"] * 10**9 + stamp["nsec"] - START) // TICK
    tree = robot.tree
    data = tree.model.createData()
    base = pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.6]))
    pin.framesForwardKinematics(tree.model, data, tree.configuration(sensors(robot, tick).q, base))
    for frame in ("l_sole", "l_hand", "head", "l_hand_dh_frame"):
        expected = data.oMf[tree.frame_id(frame)]
        assert chain(named, frame).isApprox(expected, 1e-6)


def test_forces_are_arrows_whose_tips_are_the_contact_points(converted):
    scenes = values(converted, "/icub/3d/forces")
    wrenches = {e["id"]: e for e in scenes[-1]["entities"]}["wrenches"]["arrows"]
    assert len(wrenches) == 2  # the support, and the touch that came later
    named = {
        entry["child_frame_id"]: entry
        for topic in ("static_transforms", "transforms")
        for entry in values(converted, f"/icub/3d/{topic}")[-1]["transforms"]
    }
    arrow = wrenches[1]
    length = arrow["shaft_length"] + arrow["head_length"]
    assert length == pytest.approx(0.1)  # 10 N at 1 cm/N
    turn = pin.Quaternion(np.array([arrow["pose"]["orientation"][k] for k in "xyzw"]))
    direction = turn.matrix()[:, 0]
    tip = np.array([arrow["pose"]["position"][k] for k in "xyz"]) + length * direction
    assert np.allclose(tip, chain(named, "l_hand").translation, atol=1e-6)
    hand = chain(named, "l_hand_dh_frame").rotation
    assert np.allclose(direction, hand @ np.array([0.0, 1.0, 0.0]), atol=1e-6)


def test_the_robot_is_drawn_once_and_each_body_follows_its_frame(converted, robot):
    (scene,) = values(converted, "/icub/3d/robot")
    assert all(e["frame_id"] in robot.links and e["frame_locked"] for e in scene["entities"])
    points = scene["entities"][0]["triangles"][0]
    assert max(points["indices"]) < len(points["points"])


def keys(value, path=()):
    if not isinstance(value, dict):
        return {path}
    return {path} | {found for key, entry in value.items() for found in keys(entry, (*path, key))}


def known_paths(converted):
    """Return all topics with all keys that a message of theirs has."""
    found = {}
    for _, channel, message in read(converted):
        if "/3d/" not in channel.topic and channel.topic not in found:
            found[channel.topic] = keys(json.loads(message.data))
    return found


def test_every_curve_of_the_plotjuggler_layout_is_in_a_converted_recording(converted):
    layout = ElementTree.parse(DOCS / "plotjuggler_layout.xml").getroot()
    curves = {curve.get("name", "") for curve in layout.iter("curve")}
    paths = known_paths(converted)
    names = {"/".join((topic, *path)) for topic, found in paths.items() for path in found}
    assert curves and not {c for c in curves if "/residuals:o/" not in c} - names


def test_every_series_and_topic_of_the_foxglove_layout_is_in_a_converted_recording(converted):
    layout = json.loads((DOCS / "foxglove_layout.json").read_text())
    panels = layout["configById"]
    series = {path["value"] for panel in panels.values() for path in panel.get("paths", ())}
    names = {
        ".".join((f'"{topic}"', *path))
        for topic, found in known_paths(converted).items()
        for path in found
    }
    assert series and not {s for s in series if "/residuals:o" not in s} - names
    topics = {channel.topic for _, channel, _ in read(converted)}
    drawn = {topic for panel in panels.values() for topic in panel.get("topics", {})}
    assert drawn and drawn <= topics
