"""Detection of touches that begin, fade, last and lift the heels, on a robot that stands."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import count

import numpy as np
import pytest

from estimation.contact.body_evidence import body_evidence
from estimation.contact.contact_calibration import likeliest_variances
from estimation.contact.support_watch import SupportWatch
from robot_model import Robot
from robot_model.messages import SensorFrame
from tests.estimation.standing_recordings import (
    Frames,
    Recorder,
    tared,
    watch,
)


@pytest.fixture(scope="module")
def still(robot: Robot) -> tuple[Frames, Frames]:
    """A robot at rest, and at rest while 10 N push its forearm."""
    recorder = Recorder(robot)
    rest = recorder.record(0.4)
    recorder.plant.push("l_forearm", np.zeros(3), np.array([0.0, 0.0, -10.0]), profile="ramp")
    recorder.record(1.6)
    return rest, recorder.record(0.4)


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
