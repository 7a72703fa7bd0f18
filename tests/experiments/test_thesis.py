"""The thesis's experiments, short: exact sensors leave no error, realistic ones what they must."""

import json
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import matplotlib
import numpy as np
import pytest
import yaml

from deploy.main import run as command
from experiments import external_wrench, ft_prediction
from experiments.conditions import BOTH, CONDITIONS, IDEAL, MASS, REALISTIC, UNTARED
from experiments.limb_motion import LimbMotion
from experiments.line_figure import POINTS, Panel, figure_svg
from experiments.published import TABLE_4_1
from experiments.report import Report
from experiments.stimulus import stimuli
from robot_model import Robot, load_robot

DATA = Path(__file__).parents[1] / "robot_model" / "data"
BESIDE = stimuli()[-1:]  # a force beside the frame's origin: all six components


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("icub")


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Description of a robot with few joints, on a pole."""
    text = (DATA / "arm.yaml").read_text()
    description = yaml.safe_load(text)
    description["urdf"]["path"] = str(DATA / "arm.urdf")
    description["supports"] = {"pole": [description["base_link"]]}
    file = tmp_path_factory.mktemp("small") / "small.yaml"
    file.write_text(yaml.safe_dump(description))
    return file


@pytest.fixture(scope="module")
def prediction(robot: Robot) -> Report:
    return ft_prediction.run(robot, seed=3, runs=1, postures=1)


@pytest.fixture(scope="module")
def touch(robot: Robot) -> Report:
    return external_wrench.run(robot, seed=3, runs=1, exerted=BESIDE)


def of(report: Report, condition: str, statistic: str) -> np.ndarray:
    return np.array(report.figures["rms_over_runs"][condition][statistic])


def test_the_prediction_of_exact_sensors_and_masses_is_exact(prediction: Report) -> None:
    assert of(prediction, IDEAL, "std").max() < 1e-12
    assert of(prediction, IDEAL, "mean").max() < 1e-4  # the last of the swing when it was tared


def test_wrong_masses_are_seen_and_noise_more(prediction: Report) -> None:
    forces = {c: of(prediction, c, "std")[:4, :3].max() for c in CONDITIONS}
    assert 1e-4 < forces[MASS] < forces[REALISTIC] < 1.0  # N
    assert forces[BOTH] == pytest.approx(forces[UNTARED])


def test_a_tare_takes_the_biases_away(prediction: Report) -> None:
    tared, untared = (of(prediction, c, "mean")[:, :3].max() for c in (BOTH, UNTARED))
    assert tared < 0.3 < 0.5 < untared  # N


def test_the_simulated_errors_are_below_those_of_the_real_robot(prediction: Report) -> None:
    sensors = prediction.figures["sensors"]
    for sensor, (_, std) in TABLE_4_1.items():
        ours = of(prediction, BOTH, "std")[sensors.index(sensor)]
        assert np.linalg.norm(ours[:3]) < np.linalg.norm(std[:3])
    assert all(f"`{sensor}`" in prediction.files["ft_prediction.md"] for sensor in sensors)


def test_exact_sensors_tell_the_wrench_at_the_hand_and_all_torques(touch: Report) -> None:
    kinds = np.array([kind for kind, _ in touch.figures["columns"]])
    std = of(touch, IDEAL, "std")
    assert std[kinds != "external torque"].max() < 1e-6
    # The posture yields a little to the stimulus, and its own torques with it.
    assert std[kinds == "external torque"].max() < 0.02  # N m


def test_realistic_sensors_tell_them_to_a_tenth_of_a_newton(touch: Report) -> None:
    rms = np.hypot(of(touch, BOTH, "mean"), of(touch, BOTH, "std"))
    assert 0.01 < rms[:3].max() < 0.25  # N, of 10 N
    assert rms[3:6].max() < 0.05  # N m
    assert rms[6:].max() < 0.05  # N m


def test_figures_are_small_svg_documents(prediction: Report, touch: Report) -> None:
    figures = [text for r in (prediction, touch) for f, text in r.files.items() if "svg" in f]
    assert len(figures) == 3
    for text in figures:
        assert len(text) < 200_000
        assert ElementTree.fromstring(text).tag == "{http://www.w3.org/2000/svg}svg"


def test_equal_seeds_give_equal_files(small: Path) -> None:
    robot = load_robot(small)
    first, second = (external_wrench.run(robot, 3, 1, BESIDE) for _ in range(2))
    assert first.files == second.files and first.document == second.document


def test_the_motion_is_smooth_and_stays_within_the_limits(robot: Robot) -> None:
    motion = LimbMotion(robot, seed=2, postures=3)
    times = np.arange(0.0, motion.duration, 0.01)
    q = np.array([motion.position(time) for time in times])
    assert (q >= robot.position_lower).all() and (q <= robot.position_upper).all()
    np.testing.assert_array_equal(q[0], robot.home)
    np.testing.assert_allclose(q[-1], robot.home)
    assert np.abs(np.diff(q, 2, axis=0)).max() / 0.01**2 < 10.0  # rad/s^2


def test_a_figure_keeps_few_points_of_a_long_line() -> None:
    time = np.linspace(0.0, 1.0, 20 * POINTS)
    zigzag = np.arange(len(time)) // 20 % 2
    text = figure_svg("long", time, [Panel("x [N]", {"line": zigzag})])
    paths = [element.get("d", "") for element in ElementTree.fromstring(text).iter()]
    assert POINTS / 2 < max(path.count("L") for path in paths) <= POINTS


def test_a_figure_names_units_and_lines_whatever_the_users_style() -> None:
    panels = [Panel("force [N]", {"measured": np.zeros(3), "predicted": np.ones(3)})]
    plain = figure_svg("two lines", np.arange(3.0), panels)
    with matplotlib.rc_context({"font.size": 30.0, "svg.hashsalt": "other"}):
        assert figure_svg("two lines", np.arange(3.0), panels) == plain
    for words in ("force [N]", "time [s]", "measured", "predicted", "two lines"):
        assert words in "".join(ElementTree.fromstring(plain).itertext())


def test_who_does_not_draw_does_not_load_matplotlib() -> None:
    told = "import sys, experiments.external_wrench; print('matplotlib' in sys.modules)"
    found = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "False"


def test_the_command_prints_one_document_and_writes_what_it_names(
    small, capsys, tmp_path, monkeypatch
) -> None:
    monkeypatch.setattr(external_wrench, "stimuli", lambda: BESIDE)
    arguments = ["--robot", str(small), "--runs", "1", "--json", "-o", str(tmp_path)]
    assert command(["experiment", "external_wrench", *arguments]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads((tmp_path / "external_wrench.json").read_text())
    assert printed["runs"] == 1 and set(printed["rms_over_runs"]) == set(CONDITIONS)
    names = {"external_wrench.csv", "external_wrench.md", "external_wrench.svg"}
    assert names < {path.name for path in tmp_path.iterdir()}


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["ft_predict"], "did you mean 'ft_prediction'?"),
        (["touch", "--robot", "icup"], "did you mean 'icub'?"),
        (["touch", "--runs", "0"], "--runs"),
        (["ft_prediction", "--robot", str(DATA / "arm.yaml")], "no support 'pole'"),
    ],
)
def test_a_wrong_wish_is_one_line_and_status_2(arguments, expected, capsys) -> None:
    assert command(["experiment", *arguments]) == 2
    shown = capsys.readouterr()
    assert expected in shown.err and shown.err.count("\n") == 1 and shown.out == ""
