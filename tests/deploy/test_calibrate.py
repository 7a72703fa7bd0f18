"""``wrenchbus calibrate contacts``: what is asked of whom, and when the robot moves."""

import pytest

from tests.deploy.answering import answering

ANSWER = {"date": "2026-01-01", "message": "calibrated: 2026-01-01"}


def services(bus, asked):
    """A contact detector and a simulated robot that only note what is asked of them."""

    def note(verb):
        def handle(**request):
            asked.append((verb, request))
            return ANSWER

        return handle

    detector = ("tare", "calibrate", "calibrations", "use_calibration", "forget_calibration")
    ports = {
        "/contact_detector/rpc:i": {verb: note(verb) for verb in detector},
        "/icub/sim/rpc:i": {"motion": note("motion")},
    }
    return answering(bus, "contact_detector", ports)


def test_the_robot_rests_then_moves_while_the_detector_records(verb, toy_bus):
    asked = []
    with services(toy_bus, asked):
        words = ("--seconds", "0.5", "--quiet", "0.2", "--motion", "reference")
        assert verb("calibrate", "contacts", *words).out == "calibrated: 2026-01-01\n"
    assert asked == [
        ("tare", {"seconds": 0.2}),
        ("motion", {"name": "reference"}),
        ("calibrate", {"seconds": 0.5}),
        ("motion", {"name": "stop"}),
    ]


def test_without_a_motion_the_user_is_told_to_move_the_robot(verb, toy_bus):
    asked = []
    with services(toy_bus, asked):
        told = verb("calibrate", "contacts", "--quiet", "0", "--json")
    assert "move the robot for 30 s" in told.err and told.documents == [ANSWER]
    assert asked == [("calibrate", {"seconds": 30.0})]


def test_stored_calibrations_are_listed_chosen_and_forgotten(verb, toy_bus):
    asked = []
    with services(toy_bus, asked):
        for words in (("--list",), ("--use", "none"), ("--forget", "2026-01")):
            assert verb("calibrate", "contacts", *words).status == 0
    assert asked == [
        ("calibrations", {}),
        ("use_calibration", {"date": "none"}),
        ("forget_calibration", {"date": "2026-01"}),
    ]


@pytest.mark.parametrize("words", [("--list", "--use", "x"), ("--use", "x", "--forget", "x")])
def test_calibrate_takes_one_of_its_three_options(verb, words):
    result = verb("calibrate", "contacts", *words)
    assert result.status == 2 and "expected one of --list, --use and --forget" in result.err


def test_what_cannot_be_calibrated_is_refused(verb):
    result = verb("calibrate", "sensors")
    assert result.status == 2 and "contacts" in result.err
