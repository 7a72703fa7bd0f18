"""Pushes act where, when and as hard as they were asked to."""

import numpy as np
import pytest

from robot_sim import Plant

FORCE = np.array([0.0, 0.0, 10.0])


@pytest.fixture
def plant(robot):
    return Plant(robot, base="fixed")


def force_norms(plant, ticks):
    norms = []
    for _ in range(ticks):
        plant.step()
        norms.append([np.linalg.norm(push["force_world"]) for push in plant.truth().pushes])
    return norms


def test_a_held_push_acts_from_the_next_tick_for_its_duration(plant):
    assert not plant.truth().pushes
    plant.push("l_hand", np.zeros(3), FORCE, "link", "hold", 0.01)
    norms = force_norms(plant, 20)
    assert norms[:10] == [[pytest.approx(10.0)]] * 10
    assert norms[10:] == [[]] * 10


def test_a_ramp_rises_for_half_a_second_and_stays(plant):
    plant.push("l_hand", np.zeros(3), FORCE, "link", "ramp", 2.0)
    norms = np.array(force_norms(plant, 1500))[:, 0]
    assert norms[250] == pytest.approx(5.0, abs=0.05)
    assert norms[600:] == pytest.approx(np.full(900, 10.0))


def test_a_half_sine_peaks_in_the_middle(plant):
    plant.push("l_hand", np.zeros(3), FORCE, "link", "half_sine", 0.4)
    norms = np.array(force_norms(plant, 400))[:, 0]
    assert norms[200] == pytest.approx(10.0)
    assert norms[0] == pytest.approx(0.0, abs=0.1) and norms[-1] == pytest.approx(0.0, abs=0.1)


def test_a_push_without_duration_lasts_until_released(plant):
    first = plant.push("l_hand", np.zeros(3), FORCE)
    second = plant.push("r_hand", np.zeros(3), FORCE)
    for _ in range(50):
        plant.step()
    assert plant.pushes == [first, second]
    assert plant.release(first) == [first]
    plant.step()
    assert [push["id"] for push in plant.truth().pushes] == [second]
    assert plant.release() == [second]
    plant.step()
    assert not plant.truth().pushes


def test_a_world_push_keeps_its_direction_while_the_link_turns(plant):
    force = np.array([0.0, 6.0, 0.0])
    plant.push("l_hand", np.zeros(3), force, "world")
    for _ in range(300):
        plant.step()
    assert plant.truth().pushes[0]["force_world"] == pytest.approx(force)


def test_an_unknown_link_is_an_error_with_a_near_name(plant):
    with pytest.raises(LookupError, match="did you mean 'l_forearm'"):
        plant.push("l_forarm", np.zeros(3), FORCE)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"force": [1.0, 2.0]}, "force must be 3 finite numbers"),
        ({"force": [np.nan, 0.0, 0.0]}, "force must be 3 finite numbers"),
        ({"point": [[0.0, 0.0, 0.0]]}, "point must be 3 finite numbers"),
        ({"frame": "base"}, "frame must be 'link' or 'world', got 'base'"),
        ({"profile": "step"}, "profile must be one of hold, ramp, half_sine, got 'step'"),
        ({"duration": 0.0}, "needs a positive duration"),
        ({"profile": "half_sine"}, "half_sine push needs a positive duration"),
    ],
)
def test_a_wrong_argument_is_an_error_that_says_which(plant, arguments, text):
    with pytest.raises(ValueError, match=text):
        plant.push(**({"link": "l_hand", "point": np.zeros(3), "force": FORCE} | arguments))
    assert not plant.pushes


def test_releasing_a_push_that_does_not_act_says_which_do(plant):
    plant.push("l_hand", np.zeros(3), FORCE)
    with pytest.raises(LookupError, match="push 7 does not act now; acting: 1"):
        plant.release(7)
