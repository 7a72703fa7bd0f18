"""``check``: what is said of rates while simulated time goes slower than real time."""

import pytest

from deploy.doctor.live import Look, _rate
from deploy.doctor.pace import judge_clock, pace_of

CLOCK = {"port": "/icub/clock:o", "time": 1, "state": "running", "rate": 0.2}
RAW = {"name": "/icub/raw:o", "owner": {"service": "robot_sim"}, "nominal_hz": 1000.0}


def raw_at(hz, pace):
    """What is said of raw frames that come at a rate while time goes at a pace."""
    return _rate(RAW, Look(1.0, 0, 1000.0), Look(2.0, hz, 1000.0), pace)


def test_rates_follow_the_clock_of_their_robot():
    assert pace_of("/icub/raw:o", [CLOCK]) == 0.2
    assert pace_of("/icub/clock:o", [CLOCK]) == 1.0, "which is published by wall time"
    assert pace_of("/icubus/raw:o", [CLOCK]) == 1.0
    assert pace_of("/icub/raw:o", [{**CLOCK, "rate": None}]) == 0.0


def test_slow_motion_is_no_failure_but_too_few_frames_of_it_are():
    assert raw_at(200, 0.2) == ("port /icub/raw:o", "ok", "200 Hz, nominal 1000 Hz, at 0.2 of real"
                                " time")  # fmt: skip
    assert raw_at(150, 0.2).result == "fail"
    assert raw_at(200, 1.0).result == "fail"


@pytest.mark.parametrize(
    ("change", "speed", "result", "text"),
    [
        ({"rate": 1.0}, 1.0, "ok", "1 of real time"),
        ({}, 0.2, "warn", "0.2 of real time: slow motion"),
        ({}, None, "warn", "slow motion"),
        ({}, 1.0, "fail", "0.2 of real time, expected 1: this machine is too slow"),
        ({"rate": 0.0, "state": "paused"}, 1.0, "warn", "clock resume"),
        ({"rate": None, "state": "absent"}, 1.0, "fail", "absent"),
    ],
)
def test_a_clock_is_compared_with_the_speed_that_is_wished(change, speed, result, text):
    judged = judge_clock(CLOCK | change, speed)
    assert judged.result == result and text in judged.message
