"""A recording in the place of the robot: in lockstep its estimates are the live ones, bit by bit.

When a change of the estimates is meant: ``python -m tests.system.record_reference``.
"""

from collections import Counter
from pathlib import Path

import pytest

from bus.decoder import Decoder
from bus.recording import Recording
from bus.recording.difference import differences
from robot_model import Robot, ports
from robot_model.messages import Contacts
from tests.system.lockstep_runs import REFERENCE, machine, outputs, record_live, record_replay

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]
TICKS = 340
LAST = 8  # messages that may lie in bundles that nothing completed
TOLERANCE = 1e-6  # where the reference was made by another machine's arithmetic


@pytest.fixture(scope="module")
def live(robot: Robot, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return record_live(robot, tmp_path_factory.mktemp("live") / "live.mcap", TICKS)


def assert_same_estimates(robot: Robot, live: Recording, other: Recording) -> None:
    for name, found in differences(live, other, outputs(robot)).items():
        assert (found.differing, found.largest) == (0, 0.0), name
        assert found.common > 10 and found.only_first <= 2 * LAST, (name, found)


def test_a_replay_says_what_was_said_live(robot: Robot, live: Recording, tmp_path: Path):
    assert_same_estimates(robot, live, record_replay(robot, live.path, tmp_path / "replayed.mcap"))


def test_no_estimate_changes_when_the_truth_port_is_absent(
    robot: Robot, live: Recording, tmp_path: Path
):
    truth = ports.name("truth", robot)
    assert live.ports[truth].count
    without = record_live(robot, tmp_path / "without.mcap", TICKS, truth=False)
    assert truth not in without.ports
    assert_same_estimates(robot, live, without)


def test_the_estimates_are_those_of_the_kept_recording(robot: Robot, tmp_path: Path):
    reference = Recording(REFERENCE)
    replayed = record_replay(robot, REFERENCE, tmp_path / "kept.mcap")
    same_arithmetic = machine().items() <= reference.metadata["recording"].items()
    for name, found in differences(reference, replayed, outputs(robot)).items():
        allowed = 0.0 if same_arithmetic else TOLERANCE
        assert found.largest <= allowed, (name, found)
        assert found.common > 10 and found.only_first <= LAST, (name, found)


def test_the_kept_recording_is_small_and_of_a_robot_that_is_touched(robot: Robot):
    assert REFERENCE.stat().st_size < 2_000_000
    reference = Recording(REFERENCE)
    assert reference.ports[ports.name("raw", robot)].count >= 470
    decode = Decoder(Contacts, robot.model_hash, robot.dimensions).decode
    seen: Counter[str] = Counter()
    for message in reference.messages([ports.name("contacts", robot)]):
        contacts, envelope = decode(message.data)
        if envelope.valid:
            seen.update(flag["state"] for flag in contacts.flags)
    assert seen["none"] and seen["contact"] + seen["collision"]
