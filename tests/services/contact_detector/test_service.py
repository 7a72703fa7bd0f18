"""The contact detector on the bus: what it says of a robot that is pushed, still or half blind."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bus import Received, RpcError
from tests.services.contact_detector.conftest import Bench, Recording, later


def states(received: Received) -> dict[str, str]:
    return {flag["limb"]: flag["state"] for flag in received.data.flags}


def stamped(stamp: int) -> Callable[[Received], bool]:
    """What the service said of one sensor frame, and not of the silence after it."""
    return lambda one: one.envelope.stamp == stamp and "no data" not in one.envelope.reason


def flag(received: Received, limb: str) -> dict[str, Any]:
    return next(flag for flag in received.data.flags if flag["limb"] == limb)


@pytest.fixture
def tared(bench: Bench, recording: Recording) -> Bench:
    bench.feed(recording.quiet)
    return bench


def test_it_says_that_it_is_not_tared_and_then_tares_itself(
    bench: Bench, recording: Recording
) -> None:
    bench.feed(recording.quiet[:50])
    first = bench.contacts(stamped(recording.quiet[49][0]))
    assert not first.envelope.valid
    assert "tare" in first.envelope.reason
    assert first.data.none_probability == 1.0
    bench.feed(recording.quiet[50:])
    quiet = bench.contacts(stamped(recording.quiet[-1][0]))
    assert quiet.envelope.valid
    assert set(states(quiet).values()) == {"none"}
    residuals = bench.residuals(stamped(recording.quiet[-1][0])).data
    assert np.abs(residuals.internal).max() < 0.05
    assert residuals.threshold_internal.min() > 0.0


def test_a_push_on_the_forearm_is_a_contact_there(tared: Bench, recording: Recording) -> None:
    tared.feed(recording.pushed)
    last = recording.pushed[-1][0]
    contacts = tared.contacts(stamped(last))
    touched = [limb for limb, state in states(contacts).items() if state != "none"]
    assert touched == ["l_arm"]
    assert flag(contacts, "l_arm")["force"] == pytest.approx(15.0, abs=0.5)
    assert recording.pushed[0][0] <= flag(contacts, "l_arm")["onset"] < recording.pushed[20][0]
    best = contacts.data.hypotheses[0]
    assert best["links"][0] == "l_forearm"
    assert np.linalg.norm(best["force"]) == pytest.approx(15.0, abs=0.5)
    assert np.array(best["covariance"]).shape == (6, 6)
    residuals = tared.residuals(stamped(last)).data
    assert np.linalg.norm(residuals.external[:3]) == pytest.approx(15.0, abs=1.0)
    assert residuals.valid_internal


def test_a_lost_force_sensor_costs_its_limbs_only(tared: Bench, recording: Recording) -> None:
    valid = np.ones(6, dtype=bool)
    valid[0] = False
    blind = [
        (stamp, replace(frame, ft_valid=valid, ft=frame.ft * valid[:, None]))
        for stamp, frame in recording.pushed
    ]
    tared.feed(blind)
    contacts = tared.contacts(stamped(blind[-1][0]))
    assert contacts.envelope.valid
    reasons = {flag["limb"]: flag["reason"] for flag in contacts.data.flags if not flag["valid"]}
    assert set(reasons) == {"l_arm", "root", "l_foot", "r_foot"}
    assert "l_arm_ft is invalid" in reasons["l_arm"]
    assert set(states(contacts).values()) == {"none"}
    whole = later(recording.pushed, 1.0)
    tared.feed(whole)
    assert flag(tared.contacts(stamped(whole[-1][0])), "l_arm")["state"] == "contact"


def unheard(received: Received) -> bool:
    return "no data on /icub/sensors:o" in received.envelope.reason


def test_silence_is_invalid_and_says_why(tared: Bench) -> None:
    assert not tared.contacts(unheard).envelope.valid
    residuals = tared.residuals(unheard)
    assert not residuals.envelope.valid
    assert not residuals.data.valid_external
    assert not residuals.data.external.any()


def test_an_invalid_frame_gives_an_invalid_answer(tared: Bench, recording: Recording) -> None:
    stamp, frame = recording.pushed[0]
    tared.feed([(stamp, replace(frame, imu_valid=np.array([False])))])
    contacts = tared.contacts(stamped(stamp))
    assert not contacts.envelope.valid
    assert "head_imu_0" in contacts.envelope.reason


def test_stamps_that_jump_back_start_anew_with_the_old_tare(
    tared: Bench, recording: Recording
) -> None:
    tared.feed(recording.pushed)
    again = later(recording.quiet[:30], -1.5)
    tared.feed(again)
    contacts = tared.contacts(stamped(again[-1][0]))
    assert contacts.envelope.valid
    assert set(states(contacts).values()) == {"none"}


def test_tare_names_the_limbs_and_the_supports(tared: Bench, recording: Recording) -> None:
    answer = tared.call("tare", {"seconds": 0.5}, later(recording.quiet, 2.0))
    assert answer["tared"] == ["root", "l_arm", "r_arm", "l_leg", "r_leg"]
    assert answer["unobservable"] == ["l_foot", "r_foot"]
    assert "l_foot" in answer["message"]


def test_tare_refuses_a_moving_robot(tared: Bench, recording: Recording) -> None:
    moving = [
        (stamp, replace(frame, dq=np.full_like(frame.dq, 0.2)))
        for stamp, frame in later(recording.quiet, 2.0)
    ]
    with pytest.raises(RpcError, match="moves"):
        tared.call("tare", {"seconds": 0.5}, moving)


def test_the_whole_body_has_a_flag_with_statistic_and_threshold(
    tared: Bench, recording: Recording
) -> None:
    body = tared.contacts(stamped(recording.quiet[-1][0])).data.body
    assert (body["state"], body["onset"], body["valid"]) == ("none", 0, True)
    assert body["statistic"] < body["threshold"]
    tared.feed(recording.pushed)
    contacts = tared.contacts(stamped(recording.pushed[-1][0]))
    body, arm = contacts.data.body, flag(contacts, "l_arm")
    assert body["state"] == "contact" and body["probability"] > 0.99
    assert body["force"] == pytest.approx(15.0, abs=0.5)
    assert body["onset"] <= arm["onset"]
    assert arm["statistic"] > arm["threshold"] >= 6.5


def test_a_calibration_outlives_the_service_until_it_is_forgotten(
    tared: Bench, recording: Recording
) -> None:
    answer = tared.call("calibrate", {"seconds": 0.3}, later(recording.quiet, 2.0))
    assert set(answer["thresholds"]) >= {"root", "l_arm"} and answer["samples"] > 50
    assert "icub, on floor" in answer["message"]
    again = tared.restarted()
    assert again["calibration"]["date"] == answer["date"]
    listed = tared.call("calibrations", {}, [])
    assert [one["date"] for one in listed["calibrations"]] == [answer["date"]]
    tared.call("forget_calibration", {"date": answer["date"]}, [])
    assert tared.restarted()["calibration"]["loaded"] == "no calibration is stored"
    with pytest.raises(RpcError, match="expected the date of one calibration"):
        tared.call("use_calibration", {"date": answer["date"]}, [])


def test_a_calibration_in_which_something_touches_is_refused(
    tared: Bench, recording: Recording
) -> None:
    with pytest.raises(RpcError, match="are a touch"):
        tared.call("calibrate", {"seconds": 0.3}, later(recording.pushed, 2.0))


def test_the_place_of_a_touch_is_told_while_it_lasts(tared: Bench, recording: Recording) -> None:
    tared.feed(recording.pushed)
    told = tared.points(lambda one: bool(one.data.link)).data
    assert told.link == ["l_forearm"] and told.unknown == ["force"]
    np.testing.assert_allclose(told.point[0], recording.point, atol=0.01)
    tared.feed(later(recording.quiet[:60], 4.0))
    ended = tared.points(lambda one: not one.data.link and one.envelope.stamp > 5_000_000_000)
    assert ended.envelope.valid


def test_no_place_is_told_when_told_not_to(bench: Bench, recording: Recording) -> None:
    bench.node.parameters.set("tell_points", False)
    bench.feed(recording.quiet)
    bench.feed(recording.pushed[:60])
    assert bench.contacts(stamped(recording.pushed[59][0])).data.hypotheses
    assert bench.heard_points() == []


def test_a_start_in_contact_is_no_tare(bench: Bench, recording: Recording) -> None:
    held = [(recording.pushed[0][0] + 4_000_000 * i, recording.pushed[-1][1]) for i in range(1500)]
    bench.feed(held[::5])
    contacts = bench.contacts(stamped(held[::5][-1][0]))
    assert not contacts.envelope.valid
    assert "more than a bias" in contacts.envelope.reason


def test_on_the_pole_the_classical_residual_serves(bench: Bench, recording: Recording) -> None:
    bench.node.parameters.set("support", "pole")
    bench.feed(recording.quiet[:60], recording.base)
    last = recording.quiet[59][0]
    residuals = bench.residuals(stamped(last))
    assert residuals.envelope.valid
    assert residuals.data.valid_classical
    assert not residuals.data.valid_internal
    assert not residuals.data.valid_external


def test_thresholds_and_gains_of_the_residuals_change_while_it_runs(
    tared: Bench, recording: Recording
) -> None:
    settings = tared.node.parameters
    settings.set("residuals.internal_floor", 2.5)
    settings.set("residuals.joint_gains", {"l_elbow": 50.0})
    frames = later(recording.quiet[:10], 2.0)
    tared.feed(frames)
    residuals = tared.residuals(stamped(frames[-1][0])).data
    assert residuals.valid_internal and residuals.threshold_internal.min() == 2.5
    with pytest.raises(LookupError, match="no joint 'l_elbwo'"):
        settings.set("residuals.joint_gains", {"l_elbwo": 50.0})
    assert settings.get("residuals.joint_gains") == {"l_elbow": 50.0}


@pytest.mark.parametrize(
    ("name", "value"), [("lockstep", True), ("rate", 100.0), ("inputs", {"sensors": "/x:o"})]
)
def test_what_cannot_change_while_it_runs_is_refused(bench: Bench, name: str, value: Any) -> None:
    with pytest.raises(ValueError, match=f"{name} cannot be changed while the service runs"):
        bench.node.parameters.set(name, value)


def test_a_support_that_the_robot_does_not_have_is_refused(bench: Bench) -> None:
    with pytest.raises(ValueError, match="support"):
        bench.node.parameters.set("support", "ceiling")
