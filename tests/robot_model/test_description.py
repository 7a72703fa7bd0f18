"""A description that does not fit its URDF is refused, and every mismatch is named."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from robot_model import DescriptionError, load_robot, robot_name

DATA = Path(__file__).parent / "data"


@pytest.fixture
def variant(tmp_path):
    """Load the tiny robot with changes: ``variant(lambda d: ..., urdf=[(old, new), ...])``."""

    def load(change=lambda description: None, urdf=()):
        description = yaml.safe_load((DATA / "arm.yaml").read_text())
        change(description)
        text = (DATA / "arm.urdf").read_text()
        for old, new in urdf:
            assert old in text
            text = text.replace(old, new, 1)
        (tmp_path / "arm.urdf").write_text(text)
        file = tmp_path / "arm.yaml"
        file.write_text(yaml.safe_dump(description))
        return load_robot(file)

    return load


def refused(load, *arguments, **options) -> str:
    with pytest.raises(DescriptionError) as caught:
        load(*arguments, **options)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_the_description_decides_the_joint_order(tiny):
    assert tiny.joints == ("bend", "turn", "slide")
    assert {part: list(joints) for part, joints in tiny.parts.items()} == {
        "hand": [0],
        "arm": [1, 2],
    }
    np.testing.assert_array_equal(tiny.home, [0.1, 0.2, 0.05])
    np.testing.assert_array_equal(tiny.coulomb, [0.0, 0.3, 0.0])


def test_limits_come_from_the_urdf_unless_the_description_has_its_own(tiny):
    np.testing.assert_array_equal(tiny.position_lower, [-1.5, -np.inf, -0.05])
    np.testing.assert_array_equal(tiny.position_upper, [1.5, np.inf, 0.1])
    np.testing.assert_array_equal(tiny.velocity_limit, [4.0, 3.0, 1.0])
    np.testing.assert_array_equal(tiny.torque_limit, [10.0, 40.0, 50.0])


def test_a_rotor_block_replaces_the_entries_of_its_joints(tiny):
    expected = [[0.02, 0.0, 0.01], [0.0, 0.05, 0.0], [0.01, 0.0, 0.6]]
    np.testing.assert_array_equal(tiny.rotor_inertia, expected)


def test_fixed_links_are_merged_and_sensors_split(tiny):
    assert tiny.links == ("pedestal", "upper", "fore", "stick", "hand")
    assert set(tiny.bodies["hand"].placements) == {"hand", "tool", "finger"}
    assert tiny.bodies["hand"].mass == pytest.approx(0.55)
    assert [subtree.links for subtree in tiny.subtrees] == [
        ("pedestal", "upper"),
        ("fore", "stick", "hand"),
    ]
    assert tiny.frame("tool")[0] == "hand"


def test_a_packaged_robot_that_does_not_exist_is_answered_with_those_that_do():
    assert "unknown robot; did you mean 'icub'?" in refused(load_robot, "icubb")
    assert "there are: icub" in refused(load_robot, "spot-mini-xxl")
    assert "no such description file" in refused(load_robot, "robots/none.yaml")


def test_the_name_of_a_robot_is_told_without_its_urdf(tiny, tmp_path):
    file = tmp_path / "alone.yaml"
    file.write_text((DATA / "arm.yaml").read_text())
    assert robot_name(file) == tiny.name
    assert "unknown robot; did you mean 'icub'?" in refused(robot_name, "icubb")


def test_unknown_keys_and_wrong_types_are_named(variant):
    def change(description):
        description["imu"] = []
        description["joints"][0]["kp"] = "much"
        del description["base_link"]

    message = refused(variant, change)
    for part in ("imu: unknown key", "joints.0.kp: ", "got 'much'", "base_link: field required"):
        assert part in message


def test_a_file_that_is_not_yaml_is_refused(tmp_path):
    file = tmp_path / "broken.yaml"
    file.write_text("name: [unclosed")
    assert "broken.yaml" in refused(load_robot, file)


def test_every_mismatch_is_named_in_one_error(variant):
    def change(description):
        joints = description["joints"]
        joints[0]["name"] = "bemd"
        joints[1]["home"] = 0.0
        joints[2]["home"] = 0.5
        joints.append(dict(joints[1]))
        description["locked_joints"]["grab"] = 0.0
        description["imus"] = ["fingre"]
        description["supports"]["floor"] = ["sole"]
        description["soles"]["hand"] = [[0, 0, 0]]
        description["touchable_links"] = ["hnad"]
        description["rotor_blocks"][0]["matrix"] = [[1.0, 0.0], [0.0]]
        description["ft_sensors"][0]["part"] = "arn"
        description["ft_sensors"][0]["subtree"] = "root"

    message = refused(variant, change)
    for part in (
        "unknown joint 'bemd'; did you mean 'bend'?",
        "joints: 'turn' is named 2 times",
        "joint 'bend' of the URDF is missing",
        "joint 'slide': home 0.5 is outside [-0.05, 0.1]",
        "locked_joints: unknown moving joint 'grab'",
        "imus: unknown URDF link or frame 'fingre'; did you mean 'finger'?",
        "supports.floor: unknown URDF link or frame 'sole'",
        "touchable_links: unknown URDF link or frame 'hnad'; did you mean 'hand'?",
        "soles.hand is not the frame of a support",
        "soles.hand: expected at least 3 corners, got 1",
        "matrix has rows of lengths [2, 1], expected 2 rows of 2",
        "ft_sensors.wrench: unknown part 'arn'; did you mean 'arm'?",
        "sub-tree 'root' is named 2 times",
    ):
        assert part in message


def test_rotor_blocks_must_be_physical_and_name_known_joints(variant):
    def change(description):
        description["rotor_blocks"] += [
            {"joints": ["turn", "elbow"], "matrix": [[1.0, 2.0], [2.0, 1.0]]},
            {"joints": ["bend"], "matrix": [[0.1]]},
        ]

    message = refused(variant, change)
    assert "rotor_blocks.1: unknown joint 'elbow'" in message
    assert "rotor_blocks.1: matrix is not symmetric and positive definite" in message
    assert "rotor_blocks: 'bend' is named 2 times" in message


def test_limits_that_nobody_gives_are_named(variant):
    message = refused(variant, urdf=[('velocity="4" effort="10"', 'effort="50000"')])
    assert "joint 'bend': no velocity limit here, and the URDF's is inf" in message
    assert "joint 'bend': no torque limit here, and the URDF's is 50000" in message


def test_a_sensor_must_sit_on_a_fixed_joint(variant):
    move = '<joint name="sense" type="revolute">'
    message = refused(variant, urdf=[('<joint name="sense" type="fixed">', move)])
    assert "ft_sensors.wrench: joint 'sense' is revolute, expected fixed" in message


def test_a_sensor_without_a_joint_is_named(variant):
    def change(description):
        description["ft_sensors"][0]["name"] = "wrist"

    assert "no force/torque sensor of this name" in refused(variant, change)
    wrong = [('<parent joint="sense"/>', '<parent joint="sens"/>')]
    assert "unknown joint 'sens'; did you mean 'sense'?" in refused(variant, urdf=wrong)


def test_a_sensor_reports_in_a_known_way(variant):
    edits = [("parent_to_child", "sideways"), ("<frame>sensor</frame>", "<frame>base</frame>")]
    message = refused(variant, urdf=edits)
    assert "<measure_direction> is 'sideways', expected child_to_parent" in message
    assert "<frame> is 'base', expected parent, child or sensor" in message


def test_frames_on_the_wrong_side_of_a_sensor_are_named(variant):
    def change(description):
        description["base_link"] = "hand"
        description["root_subtree"]["default_frame"] = "tool"
        description["ft_sensors"][0]["default_frame"] = "upper"
        description["ft_sensors"][0]["frame"] = "stick"

    message = refused(variant, change)
    for part in (
        "base_link: 'hand' is distal of a force/torque sensor",
        "root_subtree.default_frame: 'tool' is distal",
        "ft_sensors.wrench.default_frame: 'upper' lies elsewhere",
        "ft_sensors.wrench.frame: 'stick' is not fixed to the sensor",
    ):
        assert part in message


def test_an_inertia_that_no_body_has_is_refused(variant):
    message = refused(variant, urdf=[('ixx="0.0005" ixy="0"', 'ixx="0.5" ixy="0"')])
    assert "link 'stick': no body has its inertia" in message


def test_an_unreadable_urdf_is_one_clear_line(variant, tmp_path):
    assert "cannot read the URDF" in refused(variant, urdf=[("</robot>", "")])
    assert "malformed URDF" in refused(variant, urdf=[('value="3.0"', 'value="heavy"')])
    assert "no attribute 'value'" in refused(variant, urdf=[('<mass value="3.0"', "<mass")])
    assert "'slide' has no <child>" in refused(variant, urdf=[('<child link="stick"/>', "")])
    lost = [('<child link="tool"/>', '<child link="tol"/>')]
    assert "names an unknown link 'tol'" in refused(variant, urdf=lost)
    (tmp_path / "arm.urdf").unlink()
    message = refused(load_robot, tmp_path / "arm.yaml")
    assert "cannot read the URDF: No such file or directory" in message


def test_a_package_that_is_not_there_is_named(variant):
    def missing(description):
        description["urdf"] = {"package": "no_such_robots", "path": "arm.urdf"}

    def elsewhere(description):
        description["urdf"] = {"package": "icub_models", "path": "share/none.urdf"}

    assert "Python package 'no_such_robots' is not installed" in refused(variant, missing)
    assert "no 'share/none.urdf' in or above" in refused(variant, elsewhere)


def test_joints_of_other_kinds_must_be_locked_out(variant):
    planar = [('name="wrench_frame" type="fixed"', 'name="wrench_frame" type="planar"')]
    assert "joint 'wrench_frame': expected" in refused(variant, urdf=planar)
    mimic = [('<axis xyz="0 -1 0"/>', '<axis xyz="0 -1 0"/><mimic joint="turn"/>')]
    assert "joint 'bend' mimics another joint in the URDF: lock it" in refused(variant, urdf=mimic)


def test_ranges_of_sensors_are_optional_and_infinite_where_they_are_unknown(tiny, variant):
    assert np.isinf(tiny.ft_range).all() and tiny.ft_range.shape == (1, 6)
    assert np.isinf(tiny.imu_range).all() and tiny.imu_range.shape == (1, 6)

    def describe(description):
        description["ft_sensors"][0]["range"] = [10, 20, 30, 1, 2, 3]
        description["imu_ranges"] = {"finger": {"gyro": 5.0}}

    robot = variant(describe)
    np.testing.assert_array_equal(robot.ft_range, [[10, 20, 30, 1, 2, 3]])
    np.testing.assert_array_equal(robot.imu_range, [[5.0] * 3 + [np.inf] * 3])


def test_ranges_that_cannot_be_are_refused_with_their_key(variant):
    def short(description):
        description["ft_sensors"][0]["range"] = [10, 20, 30]

    def negative(description):
        description["ft_sensors"][0]["range"] = [10, 20, 30, 1, 2, -3]

    def unknown(description):
        description["imu_ranges"] = {"fingr": {"gyro": 5.0}}

    assert "ft_sensors.0.range" in refused(variant, short)
    assert "ft_sensors.0.range.5" in refused(variant, negative)
    assert "imu_ranges: unknown sensor 'fingr'; did you mean 'finger'?" in refused(variant, unknown)
