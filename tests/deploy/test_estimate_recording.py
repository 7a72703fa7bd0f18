"""``wrenchbus estimate`` over a recording says what the services said live."""

import json
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from bus.decoder import Decoder
from bus.recording import Recording
from deploy.main import run
from robot_model import Robot, load_robot, ports
from robot_model.messages import ExternalWrenches, FtPrediction, JointTorques, Residuals
from tests.deploy.recorded import make_recording
from tests.system.lockstep_runs import REFERENCE

DELAY = 24_000_000  # ns, of the live sensor frames
TOLERANCE = 1e-6  # the reference was made by another machine's arithmetic

Arrays = dict[str, np.ndarray]


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("icub")


@pytest.fixture(scope="module")
def found(tmp_path_factory) -> Arrays:
    out = tmp_path_factory.mktemp("estimate") / "out.npz"
    assert run(["estimate", str(REFERENCE), "-o", str(out), "--json"]) == 0
    with np.load(out) as archive:
        return {name: archive[name] for name in archive.files}


def live(robot: Robot, key: str, kind: Any, found: Arrays) -> Iterator[tuple[Any, int]]:
    """Yield what was said live, and the row of the estimate for the same instant."""
    rows = {stamp: row for row, stamp in enumerate(found["stamp"].tolist())}
    decoder = Decoder(kind, robot.model_hash)
    for message in Recording(REFERENCE).messages([ports.name(key, robot)]):
        data, envelope = decoder.decode(message.data)
        yield data, rows[envelope.stamp - DELAY]


def test_torques_and_wrenches_are_those_of_the_live_observer(robot, found):
    pairs = list(live(robot, "torques", JointTorques, found))
    assert len(pairs) > 100
    for torques, row in pairs:
        assert found["valid_joint_torque"][row].all()
        assert abs(found["joint_torque"][row] - torques.torque).max() < TOLERANCE
    ours = np.median([found["joint_torque_std"][row] for _, row in pairs], axis=0)
    theirs = np.median([torques.std for torques, _ in pairs], axis=0)
    # both are of one instant in 0.1 s, not of the same
    assert np.median(abs(ours / theirs - 1.0)) < 0.02 and abs(ours / theirs - 1.0).max() < 1.0
    for wrenches, row in live(robot, "wrenches", ExternalWrenches, found):
        for frame, wrench in zip(wrenches.frame, wrenches.wrench, strict=True):
            assert abs(found[f"wrench_{frame}"][row] - wrench).max() < TOLERANCE
    for prediction, row in live(robot, "ft_prediction", FtPrediction, found):
        for sensor, reading in zip(robot.ft_sensors, prediction.predicted, strict=True):
            assert abs(found[f"ft_predicted_{sensor}"][row] - reading).max() < TOLERANCE


def test_residuals_are_the_live_ones_before_the_tare_that_was_made_meanwhile(robot, found):
    differences = np.array(
        [
            np.append(residuals.internal, residuals.external)
            - np.append(found["residual_internal"][row], found["residual_external"][row])
            for residuals, row in live(robot, "residuals", Residuals, found)
        ]
    )
    assert len(differences) > 80
    steps = abs(np.diff(differences, axis=0)).max(axis=1)
    assert (steps > TOLERANCE).sum() == 1 and abs(differences[0]).max() < TOLERANCE


def test_sensor_frames_serve_where_no_raw_ones_were_recorded(robot, tmp_path, capsys):
    tape, out = make_recording(tmp_path / "log.mcap", robot), tmp_path / "out.npz"
    assert run(["estimate", str(tape), "-o", str(out), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["samples"] == 100 and told["valid_torques"] == 1.0
    with np.load(out) as archive:
        assert archive["stamp"][0] == -24_000_000


def test_a_recording_of_another_robot_is_one_line(robot, tmp_path, capsys):
    arm = "tests/robot_model/data/arm.yaml"
    out = tmp_path / "out.npz"
    assert run(["estimate", "--robot", arm, str(REFERENCE), "-o", str(out)]) == 1
    shown = capsys.readouterr().err
    assert "neither" in shown and "/icub/raw:o" in shown and shown.count("\n") == 1
    assert not out.exists()
