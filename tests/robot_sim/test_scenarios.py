"""Scenarios and motions: checked at load, gentle in effect, reproduced by the seed."""

import numpy as np
import pytest

from robot_sim import TICK, Plant
from robot_sim.scenario import ScenarioPlayer, load_scenario


class Listener:
    """A plant without physics, which notes what is asked of it."""

    fallen = False

    def __init__(self):
        self.time = 0
        self.asked = []

    def push(self, link, *arguments, **named):
        self.asked.append((self.time, link, arguments, named))

    def motion(self, motion):
        self.asked.append((self.time, motion.name))


def listen(robot, scenario, seconds, seed=0):
    """Return what a scenario asks of a plant."""
    plant = Listener()
    player = ScenarioPlayer(plant, load_scenario(scenario, robot), seed)
    for _ in range(round(seconds * 1000)):
        player.step()
        plant.time += TICK
    return plant.asked


def links(asked):
    return [entry[1] for entry in asked]


@pytest.mark.parametrize("name", ["demo", "quiet", "motion"])
def test_the_packaged_scenarios_fit_the_robot(robot, name):
    assert load_scenario(name, robot).description


def test_the_demo_touches_many_links_one_after_the_other_by_the_seed(robot):
    asked = listen(robot, "demo", 120.0)
    assert len(set(links(asked))) >= 6
    starts = np.diff([entry[0] for entry in asked]) * 1e-9
    assert starts.min() > 4.9 and starts.max() < 8.1
    for _, _, (_, force, *_), _ in asked:
        assert 8.0 <= np.linalg.norm(force) <= 15.0
    assert links(listen(robot, "demo", 120.0)) == links(asked)
    assert links(listen(robot, "demo", 120.0, seed=1)) != links(asked)


def test_the_robot_stands_through_the_demo(robot):
    plant = Plant(robot)
    player = ScenarioPlayer(plant, load_scenario("demo", robot), seed=2)
    pushed = 0
    for _ in range(22_000):
        player.step()
        plant.step()
        pushed = max(pushed, *plant.pushes, 0)
    assert pushed >= 2
    assert not plant.fallen


def test_a_scenario_begins_when_it_is_asked_for(robot):
    plant = Listener()
    plant.time = 20_000_000_000
    player = ScenarioPlayer(plant, load_scenario("demo", robot))
    for _ in range(10_000):
        player.step()
        plant.time += TICK
    assert min(entry[0] for entry in plant.asked) > 23_000_000_000


def test_a_planned_push_acts_when_it_should(robot, tmp_path):
    file = tmp_path / "poke.yaml"
    file.write_text(
        "pushes: [{at: 0.5, link: chest, point: [0, 0, 0], force: [1, 2, 3], duration: 0.1}]"
    )
    plant = Plant(robot)
    player = ScenarioPlayer(plant, load_scenario(file, robot))
    acting = []
    for _ in range(700):
        player.step()
        plant.step()
        acting.append(bool(plant.truth().pushes))
    assert np.flatnonzero(acting).tolist() == list(range(499, 599))


def test_a_motion_swings_the_arms_and_stops_softly(robot):
    assert links(listen(robot, "motion", 0.01)) == ["wave"]
    plant = Plant(robot, base="fixed")
    plant.motion(load_scenario("motion", robot).motion("wave"))
    elbow = robot.joints.index("l_elbow")
    positions = []
    for _ in range(5000):
        plant.step()
        positions.append(plant.q[elbow])
    assert np.ptp(positions) > 0.3
    plant.motion(None)
    for _ in range(4000):
        plant.step()
    assert plant.motion_name == ""
    assert np.abs(plant.dq).max() < 0.05


def test_a_motion_stays_within_the_joint_limits(robot):
    boards = Plant(robot).boards
    far = np.full(robot.n, 5.0)
    held = boards.torque(robot.position_upper, np.zeros(robot.n), far)
    assert held == pytest.approx(np.zeros(robot.n))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("pushes: [{at: 1, link: l_forarm, point: [0,0,0], force: [1,0,0]}]", "'l_forearm'"),
        ("pushes: [{at: 1, link: chest, point: [0,0], force: [1,0,0]}]", "pushes.0.point"),
        ("touchs: {}", "touchs"),
        ("motions: {nod: {neck_pich: {amplitude: 0.1, frequency: 1}}}", "'neck_pitch'"),
        ("motions: {nod: {neck_pitch: {amplitude: 9, frequency: 1}}}", "motions.nod.neck_pitch"),
        ("start_motion: nod", "no motion 'nod'"),
        ("pushes: [", "mine.yaml"),
    ],
)
def test_a_wrong_scenario_is_an_error_that_names_what_is_wrong(robot, tmp_path, text, message):
    file = tmp_path / "mine.yaml"
    file.write_text(text)
    with pytest.raises((ValueError, LookupError)) as error:
        load_scenario(file, robot)
    assert message in str(error.value) and "mine.yaml" in str(error.value)


def test_an_unknown_scenario_lists_those_that_exist(robot):
    with pytest.raises(LookupError, match="did you mean 'demo'"):
        load_scenario("dmo", robot)
