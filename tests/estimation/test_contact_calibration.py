"""Detection on a robot that moves, rubs and is measured wrongly, and what calibration mends."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from estimation.contact.contact_detector import ContactDetector, DetectorSettings
from estimation.contact.quiet_period import Quiet, QuietPeriod
from estimation.contact.row_covariance import RowNoise
from robot_model import Robot
from robot_sim.motions import Motion
from tests.estimation.standing_recordings import (
    PUSH,
    SWAY,
    Frames,
    Recorder,
    add,
    alarms,
    tared,
    watch,
)


@dataclass(frozen=True)
class Recording:
    """A robot at rest, swaying, swaying on, and pushed while it sways."""

    rest: Frames
    reference: Frames
    free: Frames
    pushed: Frames


@pytest.fixture(scope="module")
def rubbing(robot: Robot, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Half a newton metre of Coulomb friction in every joint, which nobody knows of."""
    profile = tmp_path_factory.mktemp("profiles") / "rubbing.yaml"
    profile.write_text("{derivatives: true, coulomb: 1.0}")
    recorder = Recorder(replace(robot, coulomb=np.full(robot.n, 0.5)), str(profile))
    rest = recorder.record(0.4)
    recorder.plant.motion(Motion("sway", SWAY))
    reference, free = recorder.record(5.0), recorder.record(3.0)
    recorder.plant.push(PUSH["link"], np.zeros(3), np.array(PUSH["force"]), frame="world")
    return Recording(rest, reference, free, recorder.record(0.4))


def record_motion(detector: ContactDetector, frames: Frames) -> Quiet:
    motion = QuietPeriod(detector.robot.joints)
    for stamp, frame in frames:
        detector.step(frame, stamp)
        add(motion, detector, frame)
    return motion.finish(still=False)


def misread(frames: Frames, gain: np.ndarray) -> Frames:
    return [(stamp, replace(frame, ft=frame.ft * gain)) for stamp, frame in frames]


def assert_calibration_ends_alarms(
    robot: Robot, recording: Recording, settings: DetectorSettings | None = None
) -> None:
    detector = tared(robot, recording.rest, settings)
    assert any(alarms(detector, recording.reference))  # before
    detector = tared(robot, recording.rest, settings)
    calibration = detector.calibrate(record_motion(detector, recording.reference))
    detector.reset()
    assert watch(detector, recording.free) == set()
    assert {"r_leg", "body"} <= watch(detector, recording.pushed)
    # a service that starts again has the calibration from a file, and its own tare
    again = tared(robot, recording.rest, settings)
    again.use(calibration)
    assert watch(again, recording.free) == set()
    assert {"r_leg", "body"} <= watch(again, recording.pushed)


def test_unknown_friction_alarms_a_detector_that_trusts_torques_until_it_is_calibrated(
    robot: Robot, rubbing: Recording
) -> None:
    trusting = DetectorSettings(noise=RowNoise(friction=0.05))
    assert_calibration_ends_alarms(robot, rubbing, trusting)


def test_friction_of_half_a_newton_metre_is_no_touch_by_default(
    robot: Robot, rubbing: Recording
) -> None:
    assert watch(tared(robot, rubbing.rest), rubbing.free) == set()


def test_wrong_gains_of_the_force_sensors_alarm_until_they_are_calibrated(
    robot: Robot, rubbing: Recording
) -> None:
    pieces = (rubbing.rest, rubbing.reference, rubbing.free, rubbing.pushed)
    wrong = Recording(*(misread(each, wrong_gain()) for each in pieces))
    assert_calibration_ends_alarms(robot, wrong, DetectorSettings(gain_error=0.0))


def test_force_sensors_whose_gains_are_two_percent_wrong_do_not_alarm_by_default(
    robot: Robot, rubbing: Recording
) -> None:
    detector = tared(robot, misread(rubbing.rest, wrong_gain()))
    assert watch(detector, misread(rubbing.reference, wrong_gain())) == set()
    assert {"r_leg", "body"} <= watch(detector, misread(rubbing.pushed, wrong_gain()))


def wrong_gain() -> np.ndarray:
    return 1.0 + 0.02 * np.random.default_rng(3).standard_normal((6, 6)).clip(-2.0, 2.0)


def test_nobody_need_tell_that_the_encoders_of_a_swaying_robot_have_twelve_bits(
    robot: Robot,
) -> None:
    recorder = Recorder(robot, "realistic_12bit")
    detector = tared(robot, recorder.record(0.4))
    recorder.plant.motion(Motion("sway", SWAY))
    assert watch(detector, recorder.record(3.0)) == set()
    recorder.plant.push(PUSH["link"], np.zeros(3), np.array(PUSH["force"]), frame="world")
    assert {"r_leg", "body"} <= watch(detector, recorder.record(0.4))


def test_floors_are_learnt_where_the_errors_are(robot: Robot, rubbing: Recording) -> None:
    gain = np.ones((6, 6))
    gain[4, :3] = 1.03  # of the left foot
    detector = tared(robot, misread(rubbing.rest, gain), DetectorSettings(gain_error=0.0))
    motion = record_motion(detector, misread(rubbing.reference, gain))
    floor = np.sqrt(detector.calibrate(motion).floor)
    forces = floor[detector.rows.layout.tree.cut_v][:, :3].max(axis=1)
    assert forces[4] > 0.3
    assert forces[:2].max() < 0.05  # the arms stay as sensitive as they were


def friction_found(detector: ContactDetector, motion: Frames) -> dict[str, float]:
    """What a calibration found, by joint [N m]."""
    floor = detector.calibrate(record_motion(detector, motion)).floor
    found = np.sqrt(floor[detector.rows.layout.tree.joint_v])
    return dict(zip(detector.robot.joints, found.tolist(), strict=True))


def test_a_calibration_finds_the_friction_of_the_joints_that_move(
    robot: Robot, rubbing: Recording
) -> None:
    found = friction_found(tared(robot, rubbing.rest), rubbing.reference)
    assert all(0.35 < found[joint] < 0.7 for joint in ("l_elbow", "neck_yaw", "torso_yaw"))
    assert found["l_wrist_prosup"] >= 0.3  # it rested, so that friction is still expected


@pytest.fixture(scope="module")
def noisy(robot: Robot) -> tuple[Frames, Frames]:
    """A robot of realistic sensors at rest, and swaying."""
    recorder = Recorder(robot, "realistic")
    rest = recorder.record(0.4)
    recorder.plant.motion(Motion("sway", SWAY))
    return rest, recorder.record(3.0)


def test_a_calibration_finds_that_joints_do_not_rub(
    robot: Robot, noisy: tuple[Frames, Frames]
) -> None:
    rest, motion = noisy
    found = friction_found(tared(robot, rest), motion)
    assert all(found[joint] < 0.1 for joint in SWAY)
    assert found["l_wrist_prosup"] == pytest.approx(0.3)


def test_a_calibration_sees_the_motion_as_the_detector_does(
    robot: Robot, noisy: tuple[Frames, Frames]
) -> None:
    rest, motion = noisy
    detector = tared(robot, rest)
    calibration = detector.calibrate(record_motion(detector, motion))
    detector.reset()
    seen = 0.0
    for stamp, frame in motion:
        detector.step(frame, stamp)
        seen = max(seen, detector.body.statistic)
    margin = detector.settings.levels.margin
    assert calibration.body_threshold == pytest.approx(margin * seen, rel=0.1)


def test_biases_of_the_sensors_stay_in_their_axes_while_the_robot_moves(
    robot: Robot, rubbing: Recording
) -> None:
    rng = np.random.default_rng(4)
    bias = np.repeat([1.0, 0.03], 3) * rng.standard_normal((6, 6)).clip(-2.0, 2.0)

    def biased(frames: Frames) -> Frames:
        return [(stamp, replace(frame, ft=frame.ft + bias)) for stamp, frame in frames]

    detector = tared(robot, biased(rubbing.rest))
    assert watch(detector, biased(rubbing.free)) == set()
