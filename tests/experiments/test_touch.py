"""The touch benchmark: what it draws, that it goes on where it stopped, and its tables."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from deploy.main import run as command
from experiments.touch import run
from experiments.touch.cases import contact_free_case, pushed_case
from experiments.touch.conditions import MIX, VARIANTS, Condition, drawn
from experiments.touch.jobs import Runner, rounded
from experiments.touch.motions import CONTACT_FREE
from experiments.touch.pushes import CONE, FORCES, PushGenerator, TouchPush
from experiments.touch.store import Item, Store
from robot_model import Robot, load_robot
from robot_sim.pushes import PushShape

SEED = 4131  # both pushes are short, at rest; nothing was tuned on it
TIMES = {"step_time", "locate_time"}


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("icub")


@pytest.fixture(scope="module")
def generator(robot: Robot) -> PushGenerator:
    return PushGenerator(robot)


@pytest.mark.timeout(300)
def test_exact_sensors_name_the_link_and_a_second_run_goes_on(robot: Robot, tmp_path: Path) -> None:
    options = {"profiles": ["ideal"], "variants": ["exact_masses"], "folder": tmp_path}
    run(robot, SEED, 1, **options)
    before = (tmp_path / "touch.jsonl").read_text()
    done = []
    report = run(robot, SEED, 2, progress=lambda *now: done.append(now), **options)
    assert done == [(1, 1)]  # one was there
    assert (tmp_path / "touch.jsonl").read_text().startswith(before)
    records = Store(tmp_path).records("push")
    assert [record["index"] for record in records] == [0, 1]
    for record in records:
        assert record["detected"] and record["first"]
        assert record["point_error"] < 0.01
    assert report.document["pushes"] == 2
    assert run(robot, SEED, 2, **options).document == report.document  # nothing left to do


@pytest.mark.timeout(300)
def test_a_run_depends_on_seed_and_index_alone_and_can_be_drawn(robot: Robot) -> None:
    condition = Condition("mujoco", "realistic", "usual", "surface")
    stored = Runner(robot).perform(Item("push", SEED, 0, condition))
    report = run(robot, SEED, draw=0, profiles=["realistic"])
    drawn = {name: rounded(value) for name, value in report.document.items()}
    assert {k: v for k, v in drawn.items() if k not in TIMES} == {
        k: v for k, v in stored.items() if k not in TIMES
    }
    (picture,) = report.files.values()
    assert picture.lstrip().startswith("<?xml") and picture.rstrip().endswith("</svg>")


def test_pushes_press_into_the_surface_of_links_that_are_seen(
    robot: Robot, generator: PushGenerator
) -> None:
    surface = robot.load_surface()
    names = [body.name for body in surface.bodies]
    for index in range(60):
        case = pushed_case(generator, robot, 3, index)
        (push,) = case.pushes
        subtree = robot.subtrees[robot.subtree_of(push.link)].name
        assert "foot" not in subtree and (case.base == "free" or subtree != "root")
        assert 0.99 * FORCES[0] <= push.size <= FORCES[1]
        mine = np.flatnonzero(surface.body == names.index(push.link))
        near = mine[np.linalg.norm(surface.points[mine] - push.point, axis=1) < 0.02]
        inward = -surface.normals[near] @ push.force / push.size
        assert inward.max() > np.cos(1.5 * CONE)


def test_the_description_says_which_links_are_pushed(robot: Robot) -> None:
    chosen = replace(robot, touchable_links=("head", "l_hand", "r_sole"))
    generator = PushGenerator(chosen)
    names = {robot.subtrees[i].name for i in generator.subtrees("free")}
    assert names == {"root", "l_arm"}  # a foot is never pushed
    cases = [pushed_case(generator, chosen, 3, index) for index in range(20)]
    assert {case.pushes[0].link for case in cases} <= {"head", "l_hand"}


def test_two_contacts_are_where_the_variant_says(robot: Robot, generator: PushGenerator) -> None:
    for index in range(10):
        single = pushed_case(generator, robot, 3, index)
        apart = pushed_case(generator, robot, 3, index, "apart")
        together = pushed_case(generator, robot, 3, index, "together")
        for case in (apart, together):
            assert case.kind == single.kind
            np.testing.assert_array_equal(case.pushes[0].force, single.pushes[0].force)
        subtrees = [[robot.subtree_of(p.link) for p in c.pushes] for c in (apart, together)]
        assert subtrees[0][0] != subtrees[0][1] and subtrees[1][0] == subtrees[1][1]
        assert together.pushes[0].link != together.pushes[1].link


def test_a_sub_tree_of_one_link_is_pushed_twice_on_it(robot: Robot) -> None:
    hand = robot.links.index("l_hand")

    class OneLink(PushGenerator):
        def draw(self, random: np.random.Generator, subtree: int, base: str) -> TouchPush:
            return replace(super().draw(random, subtree, base), link=robot.links[hand])

    case = pushed_case(OneLink(robot), robot, 3, 0, "together")
    one, other = case.pushes
    assert one.link == other.link == "l_hand"
    assert not np.array_equal(one.point, other.point)


def test_the_mixture_draws_every_condition_and_every_kind_of_motion(robot: Robot) -> None:
    assert {drawn(1, index) for index in range(200)} == {
        (profile, variant) for _, profile, variant in MIX
    }
    kinds = {contact_free_case(robot, 1, index).kind for index in range(len(CONTACT_FREE))}
    assert kinds == set(CONTACT_FREE)


@pytest.mark.parametrize("size", [6.0, 40.0])
def test_a_push_is_noticeable_from_five_newtons_or_half_its_peak(size: float) -> None:
    force = np.array([0.0, 0.0, size])
    ramp = TouchPush("chest", np.zeros(3), force, "ramp", PushShape("ramp", rise=0.2))
    tap = TouchPush("chest", np.zeros(3), force, "tap", PushShape("half_sine", 0.1))
    for push in (ramp, tap):
        reached = size * push.shape.amplitude(push.noticeable)
        assert reached == pytest.approx(min(5.0, size / 2))


def test_tables_are_made_of_stored_scores_alone(robot: Robot, tmp_path: Path) -> None:
    store, condition = Store(tmp_path), Condition("mujoco", "realistic", "usual", "surface")
    for index in range(24):
        store.add(Item("push", 9, index, condition), score(right=index < 18))
    free = {"motion": "sway", "seconds": 1800.0, "alarms": 2, "flagged_share": 0.01}
    store.add(Item("free", 9, 0, condition), free | {"limbs": ["root"], "fell": False})
    report = run(robot, 9, 0, folder=tmp_path)
    text = "\n".join(report.lines)
    assert "link first" in text and "75 %" in text and "missed" in text
    assert "0.9 to 0.97" in text  # the reliability of the probabilities
    (target,) = [row for row in report.document["tables"][0]["rows"] if row[0] == "link first"]
    assert target[3:] == ["75 %", "24 pushes", "missed"]
    (alarms,) = [row for row in report.document["tables"][0]["rows"] if "alarms" in row[0]]
    assert alarms[3] == "4 /h"


def score(right: bool) -> dict:
    return {
        "motion": "sway", "kind": "ramp", "links": ["chest"], "subtrees": ["root"],
        "forces": [12.0], "fell": False, "early": False, "detected": True, "limb": True,
        "delay": 0.004, "flagged": ["root"], "ranking": ["chest" if right else "neck_1", "head"],
        "probabilities": [0.95, 0.05], "none_probability": 0.001, "first": right,
        "among_three": right, "point_error": 0.003, "force_error": 0.2, "step_time": 2e-4,
        "locate_time": 9e-3,
    }  # fmt: skip


def test_a_line_that_was_cut_off_is_dropped(tmp_path: Path) -> None:
    condition = Condition("mujoco", "realistic", "usual", "surface")
    store = Store(tmp_path)
    store.add(Item("push", 9, 0, condition), score(right=True))
    whole = (tmp_path / "touch.jsonl").read_text()
    (tmp_path / "touch.jsonl").write_text(whole + whole[:40])
    assert len(Store(tmp_path).records("push")) == 1
    assert json.loads((tmp_path / "touch.jsonl").read_text())["index"] == 0
    (tmp_path / "touch.jsonl").write_text(whole[:40] + "\n" + whole)
    with pytest.raises(ValueError, match="line 1"):
        Store(tmp_path)


@pytest.mark.parametrize(
    "options", [{"physics": "bullet"}, {"variants": ["wet"]}, {"methods": ["eyes"]}]
)
def test_what_does_not_exist_is_refused(robot: Robot, options: dict) -> None:
    with pytest.raises(ValueError, match="must be one of"):
        run(robot, 1, 1, **options)


def test_the_help_of_the_command_names_every_variant(capsys: pytest.CaptureFixture) -> None:
    assert command(["experiment", "--help"]) == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in VARIANTS)


def test_every_variant_of_the_mixture_exists() -> None:
    assert {variant for _, _, variant in MIX} <= set(VARIANTS)
