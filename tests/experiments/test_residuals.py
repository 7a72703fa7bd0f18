"""R's comparison of residuals: the classical one is wrong inside, forces come out right."""

from types import SimpleNamespace

import numpy as np
import pytest

from experiments.contact_candidates import CandidateFinder, summary
from experiments.residual_run import Push, pushed
from experiments.residual_timing import timings
from experiments.residuals import AMPLITUDE, SHOULDERS, internal_rows, known_rows, run
from robot_model import Robot, load_robot


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("icub")


def test_the_internal_residual_is_right_inside_and_forces_at_known_points_too(robot: Robot) -> None:
    places = [Push(link, np.zeros(3), AMPLITUDE) for link in SHOULDERS]
    one, two = (pushed(robot, places[:count], 0.4, 0.15) for count in (1, 2))
    _, real, internal, classical = internal_rows(robot, one)[-2]  # the norm of all joints
    assert internal < 0.05 * real
    assert classical > real  # joints above the base feel what goes through the legs
    errors = {(count, by): largest for count, by, _, largest in known_rows(one, two)}
    assert len(errors) == 5
    assert max(errors.values()) < 0.05 * np.linalg.norm(AMPLITUDE)


def test_the_line_enters_several_bodies_and_torques_find_the_pushed_one(robot: Robot) -> None:
    found, example = summary(robot, 1, 12)
    assert found.pushes == 12
    assert found.bodies > 1.0 and found.entries >= found.bodies
    assert found.first >= 0.9
    assert example[0][3] < 1e-9 and "(pushed)" in example[0][0]


def test_torques_do_not_tell_points_of_one_body_apart(robot: Robot) -> None:
    finder = CandidateFinder(robot)
    force = np.array([3.0, -8.0, 4.0])
    along = 0.01 * finder.placements["chest"].rotation.T @ force
    near, far = (finder.torque("chest", shift * along, force) for shift in (0.0, 1.0))
    np.testing.assert_allclose(near, far, atol=1e-9)


def test_every_way_is_timed_beside_the_internal_residual(robot: Robot) -> None:
    times = {name: ratio for name, _, ratio in timings(robot, 1, 2)}
    assert times["internal and external"] == 1.0
    assert len(times) == 4 and min(times.values()) > 0.0


@pytest.mark.parametrize(("links", "runs", "text"), [((), 1, "no link"), (SHOULDERS, 0, "1 run")])
def test_what_cannot_be_is_refused(links: tuple[str, ...], runs: int, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        run(SimpleNamespace(name="legs", links=links), 1, runs)  # type: ignore[arg-type]
