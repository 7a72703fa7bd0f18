"""``wrenchbus tare``: what is asked of whom."""

import pytest

from deploy.verbs.robot import patience
from robot_sim.config import SimConfig
from tests.deploy.answering import answering

TARES = {"file": "/state/icub.json", "in_use": "", "tares": [], "message": "no tare is stored"}


def observer(bus, asked):
    """A torque observer that only notes what is asked of it."""

    def note(verb, answer):
        def handle(**request):
            asked.append((verb, request))
            return answer

        return handle

    verbs = {
        "tare": note("tare", {"message": "tared: l_arm_ft"}),
        "tares": note("tares", TARES),
        "use_tare": note("use_tare", {"message": "in use: 2026-01-01"}),
        "revert_tare": note("revert_tare", {"message": "back to no offsets"}),
    }
    return answering(bus, "torque_observer", {"/torque_observer/rpc:i": verbs})


def test_tare_lists_chooses_and_reverts_what_the_observer_stores(verb, toy_bus):
    asked = []
    with observer(toy_bus, asked):
        tared = verb("tare", "--seconds", "0.1", "--stance", "pole")
        assert tared == (0, "torque_observer: tared: l_arm_ft\n", "")
        assert verb("tare", "--list", "--json").documents == [{"torque_observer": TARES}]
        assert verb("tare", "--use", "2026-01").out == "torque_observer: in use: 2026-01-01\n"
        assert verb("tare", "--revert").status == 0
    assert asked == [
        ("tare", {"seconds": 0.1, "stance": "pole"}),
        ("tares", {}),
        ("use_tare", {"date": "2026-01"}),
        ("revert_tare", {}),
    ]


def test_the_answer_is_awaited_in_the_slowest_motion_too():
    slowest = 0.05
    assert SimConfig(speed=slowest) and patience(2.0) > 2.0 / slowest
    with pytest.raises(ValueError):
        SimConfig(speed=0.9 * slowest)


@pytest.mark.parametrize("words", [("--list", "--revert"), ("--use", "x", "--list")])
def test_tare_takes_one_of_its_three_options(verb, words):
    result = verb("tare", *words)
    assert result.status == 2 and "expected one of --list, --use and --revert" in result.err


def test_without_an_observer_there_is_nothing_to_list(verb):
    result = verb("tare", "--list")
    assert result.status == 1 and "torque_observer must run" in result.err
