"""Detection on a robot that moves, rubs and is measured wrongly, or is hardly touched."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count

import numpy as np
import pytest

from estimation.contact.body_evidence import body_evidence
from estimation.contact.contact_calibration import likeliest_variances
from estimation.contact.contact_detector import ContactDetector, DetectorSettings
from estimation.contact.quiet_period import Quiet, QuietPeriod
from estimation.contact.row_covariance import RowNoise
from estimation.contact.support_watch import SupportWatch
from estimation.sensor_pipeline import SensorPipeline
from robot_model import Robot
from robot_model.messages import SensorFrame
from robot_sim import Plant
from robot_sim.motions import Motion, Sinusoid

EVERY = 4  # ticks of 1 ms between frames
Frames = list[tuple[int, SensorFrame]]  # stamp [ns], frame
SWAY = {  # shifts 100 N from foot to foot, and turns torso, neck and arms
    "l_hip_roll": Sinusoid(amplitude=0.03, frequency=0.5),
    "l_ankle_roll": Sinusoid(amplitude=0.03, frequency=0.5),
    "r_hip_roll": Sinusoid(amplitude=0.03, frequency=0.5, phase=np.pi),
    "r_ankle_roll": Sinusoid(amplitude=0.03, frequency=0.5, phase=np.pi),
    "torso_yaw": Sinusoid(amplitude=0.1, frequency=0.4),
    "neck_yaw": Sinusoid(amplitude=0.25, frequency=0.6),
    "l_elbow": Sinusoid(amplitude=0.25, frequency=0.5),
    "r_shoulder_pitch": Sinusoid(amplitude=0.25, frequency=0.7),
}
PUSH = {"link": "r_upper_leg", "force": [0.0, -15.0, 0.0]}


@dataclass(frozen=True)
class Recording:
    """A robot at rest, swaying, swaying on, and pushed while it sways."""

    rest: Frames
    reference: Frames
    free: Frames
    pushed: Frames


class Recorder:
    """A standing plant with exact sensors."""

    def __init__(self, robot: Robot, profile: str = "ideal"):
        self.plant, self._pipeline = Plant(robot, profile=profile), SensorPipeline(robot)
        self._record(2000)

    def record(self, seconds: float) -> Frames:
        return list(self._record(round(seconds * 1000)))

    def _record(self, ticks: int) -> Frames:
        frames = []
        for tick in range(ticks):
            self.plant.step()
            if tick % EVERY == EVERY - 1:
                frames.append(
                    (self.plant.time, self._pipeline.step(self.plant.raw(), self.plant.time))
                )
        return frames


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


@pytest.fixture(scope="module")
def still(robot: Robot) -> tuple[Frames, Frames]:
    """A robot at rest, and at rest while 10 N push its forearm."""
    recorder = Recorder(robot)
    rest = recorder.record(0.4)
    recorder.plant.push("l_forearm", np.zeros(3), np.array([0.0, 0.0, -10.0]), profile="ramp")
    recorder.record(1.6)
    return rest, recorder.record(0.4)


def tared(robot: Robot, rest: Frames, settings: DetectorSettings | None = None) -> ContactDetector:
    detector = ContactDetector(robot, settings=settings)
    quiet = QuietPeriod(robot.joints)
    for stamp, frame in rest:
        detector.step(frame, stamp)
        add(quiet, detector, frame)
    detector.tare(quiet.finish())
    return detector


def add(period: QuietPeriod, detector: ContactDetector, frame: SensorFrame) -> None:
    rows = detector.untared_rows
    wrenches = detector.rows.wrenches(rows)
    period.add(frame, rows, detector.rows.predicted, wrenches, np.zeros(0), detector.tared_rows)


def alarms(detector: ContactDetector, frames: Frames) -> Iterator[set[str]]:
    """Yield the names of the flags that are raised, frame by frame."""
    for stamp, frame in frames:
        flags = [*detector.step(frame, stamp), detector.body]
        yield {flag.limb for flag in flags if flag.state != "none"}


def watch(detector: ContactDetector, frames: Frames) -> set[str]:
    """Return the names of all flags that are raised."""
    return set().union(*alarms(detector, frames))


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


def test_the_joint_statistic_is_the_largest_gain_of_a_wrench_on_any_body(
    robot: Robot, still: tuple[Frames, Frames]
) -> None:
    rest, pushed = still
    detector = tared(robot, rest)
    stamp, frame = pushed[-1]
    detector.reset()  # what follows is computed at this posture
    detector.step(frame, stamp)
    rows = detector.rows
    bodies = ~np.isin(rows.layout.subtree, rows.removed.subtrees)
    args = rows.layout.bears[bodies], rows.jacobian, detector.covariance, detector.tared_rows
    expected = np.sqrt(body_evidence(*args).gain.max())
    assert detector.body.statistic == pytest.approx(expected, rel=1e-6)
    assert detector.body.force == pytest.approx(10.0, abs=0.3)


def test_a_touch_that_only_the_body_shows_stays_on_its_limb_while_it_fades(
    robot: Robot, still: tuple[Frames, Frames]
) -> None:
    rest, pushed = still
    detector = tared(robot, rest)
    detector.monitor.calibrate(np.full(len(robot.subtrees), 1e6))  # limbs show nothing
    stamps = count(rest[-1][0] + 4_000_000, 4_000_000)
    seen = []
    for _, frame in (*pushed[:25], *rest[:50]):
        detector.step(frame, next(stamps))
        seen.append(detector.touched)
    assert seen[-1] == []
    assert {limb for limbs in seen for limb in limbs} == {robot.subtree_of("l_forearm")}


def test_a_renewal_piece_by_piece_ends_where_one_at_once_does(
    robot: Robot, still: tuple[Frames, Frames]
) -> None:
    rest, pushed = still
    detector = tared(robot, rest)
    stamps, frame = count(rest[-1][0] + 4_000_000, 4_000_000), pushed[-1][1]

    def step() -> list[float]:
        flags = *detector.step(frame, next(stamps)), detector.body
        return [flag.statistic for flag in flags]

    before, *_, piece_by_piece = [step() for _ in range(60)]
    detector.reset()
    at_once = step()
    assert before[-1] != pytest.approx(at_once[-1], rel=1e-5)
    assert piece_by_piece == pytest.approx(at_once, rel=1e-9, abs=1e-9)


def test_a_detector_that_steps_slowly_renews_all_in_one_step(
    robot: Robot, still: tuple[Frames, Frames]
) -> None:
    rest, pushed = still
    detector = tared(robot, rest)
    stamp, frame = pushed[-1]
    for later in 100_000_000, 200_000_000:  # the second time nothing has changed
        slowly = detector.step(frame, rest[-1][0] + later)
    detector.reset()
    at_once = detector.step(frame, stamp)
    for one, other in zip(slowly, at_once, strict=True):
        assert one.statistic == pytest.approx(other.statistic, rel=1e-9, abs=1e-9)


def test_a_push_that_lifts_the_heels_is_one_touch_and_the_rocking_after_it_none(
    robot: Robot, still: tuple[Frames, Frames]
) -> None:
    recorder = Recorder(robot)
    detector = tared(robot, recorder.record(0.4))
    push = {"point": np.zeros(3), "force": np.array([26.0, 0.0, 0.0]), "frame": "world"}
    recorder.plant.push("chest", profile="ramp", duration=1.0, **push)
    raised, reasons = set(), set()
    for stamp, frame in recorder.record(1.0):
        flags = detector.step(frame, stamp)
        raised |= {flag.limb for flag in (*flags, detector.body) if flag.state != "none"}
        reasons |= {flag.reason for flag in flags if "foot" in flag.limb}
    assert raised == {"root", "body"}
    assert any("stands on the edge of its sole" in reason for reason in reasons)
    watch(detector, recorder.record(0.3))
    assert watch(detector, recorder.record(1.5)) == set()


def test_a_support_says_when_it_is_unsteady(robot: Robot, still: tuple[Frames, Frames]) -> None:
    stamp, frame = still[0][-1]
    supports, valid = SupportWatch(robot, robot.supports["floor"]), np.ones(6, dtype=bool)
    left = robot.subtree_of("l_sole")
    assert supports.look(frame.ft, valid, stamp) == {}
    ft = frame.ft.copy()
    ft[4] *= 1.2  # 32 N more within 20 ms
    reasons = supports.look(ft, valid, stamp + 20_000_000)
    assert set(reasons) == {left} and "fast" in reasons[left]
    assert not supports.is_steady(stamp + 100_000_000)
    assert supports.look(ft, valid, stamp + 40_000_000) == {}
    assert supports.is_steady(stamp + 600_000_000)
    assert "hardly loaded" in supports.look(0.01 * ft, valid, stamp + 9_000_000_000)[left]
    assert supports.look(0.01 * ft, valid & False, stamp + 9_100_000_000) == {}


def blend(rest: SensorFrame, pushed: SensorFrame, share: float) -> SensorFrame:
    """Return the frame of a robot that is pushed by a share of the force."""
    names = ("q", "motor_torque", "ft", "imu_acc")
    values = {n: (1 - share) * getattr(rest, n) + share * getattr(pushed, n) for n in names}
    zero = {n: np.zeros_like(getattr(rest, n)) for n in ("dq", "ddq", "imu_gyro", "imu_dgyro")}
    return replace(rest, **values, **zero)


def pressed(still: tuple[Frames, Frames], rise: float, held: float, rate: int) -> Iterator:
    """Yield stamps and frames at ``rate`` Hz of a force that rises for a time, then stays [s]."""
    (stamp, rest), (_, pushed) = still[0][-1], still[1][-1]
    for step in range(1, round(rate * (rise + held)) + 1):
        share = min(1.0, step / (rate * rise)) if rise else 1.0
        yield stamp + 1_000_000_000 * step // rate, blend(rest, pushed, share)


def test_a_slow_press_is_detected_long_before_it_is_strong(
    robot: Robot, still: tuple[Frames, Frames]
) -> None:
    detector = tared(robot, still[0])
    for stamp, frame in pressed(still, 5.0, 1.0, rate=25):
        flags = detector.step(frame, stamp)
        if detector.body.state != "none":
            break
    arm = robot.subtree_of("l_forearm")
    assert detector.body.state == "contact"
    assert flags[arm].force < 5.0


def test_a_push_of_two_minutes_is_not_tared_away(
    robot: Robot, still: tuple[Frames, Frames]
) -> None:
    detector = tared(robot, still[0])
    arm, forces = robot.subtree_of("l_forearm"), []
    for stamp, frame in pressed(still, 0.0, 120.0, rate=2):
        flag = detector.step(frame, stamp)[arm]
        forces.append(flag.force)
    assert flag.state == "contact" and flag.onset < still[0][-1][0] + 600_000_000
    np.testing.assert_allclose(forces, 10.0, atol=0.3)


def test_likeliest_variances_find_the_row_that_is_noisier_than_stated() -> None:
    rng = np.random.default_rng(6)
    removal = np.eye(4)
    removal[0, 3] = 0.5  # the last reading disturbs the first row too
    true = np.array([1.0, 1.0, 9.0, 4.0])
    rows = (np.sqrt(true) * rng.standard_normal((20_000, 4))) @ removal.T
    found = likeliest_variances(rows.T @ rows / len(rows), np.zeros((4, 4)), removal, np.ones(4))
    np.testing.assert_allclose(found, true, rtol=0.05)
