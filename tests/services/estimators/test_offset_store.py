"""Stored offsets: listed, chosen, reverted; what is not ours is refused."""

import json

import numpy as np
import pytest

from estimation.resting import RestingMean
from estimation.tare import TareResult
from estimation.torque_observer import TorqueObserver
from robot_model import load_robot
from robot_model.dated_store import StoreError
from services.torque_observer.offset_store import OffsetStore
from services.torque_observer.offsets import Offsets

ROBOT = load_robot("icub")
K = len(ROBOT.ft_sensors)


@pytest.fixture
def offsets(tmp_path):
    return Offsets(TorqueObserver(ROBOT), OffsetStore(ROBOT, 3, tmp_path))


def found(offsets, value):
    spread = np.full((K, 6), 0.25)
    rest = RestingMean(np.array(ROBOT.home), np.zeros((K, 6)), np.zeros(3), 1000, spread)
    result = TareResult(np.full((K, 6), value), ROBOT.ft_sensors, (), (), ("root_link",))
    return offsets.found(result, rest, "pole")


def file_of(tmp_path):
    return tmp_path / "icub.json"


def changed(tmp_path, change):
    content = json.loads(file_of(tmp_path).read_text())
    change(content)
    file_of(tmp_path).write_text(json.dumps(content))


def test_a_tare_is_stored_with_all_that_belongs_to_it(offsets, tmp_path):
    record = found(offsets, 1.5)
    (stored,) = offsets.listed()["tares"]
    assert stored == record.model_dump() and stored["date"].endswith("Z")
    assert (stored["robot"], stored["model"]) == ("icub", ROBOT.model_hash)
    assert (stored["stance"], stored["samples"]) == ("pole", 1000)
    assert stored["offset"]["l_arm_ft"] == [1.5] * 6 and stored["spread"]["l_arm_ft"] == [0.25] * 6
    assert stored["posture"]["l_elbow"] == pytest.approx(0.9)
    assert [path.name for path in tmp_path.iterdir()] == ["icub.json"]


def test_only_so_many_are_kept_and_the_oldest_goes(offsets, monkeypatch):
    stamps = iter(f"2026-01-0{day}T00:00:00.000Z" for day in range(1, 6))
    monkeypatch.setattr("services.torque_observer.offsets.date_of_now", lambda: next(stamps))
    for value in range(5):
        found(offsets, float(value))
    dates = [tare["date"][:10] for tare in offsets.listed()["tares"]]
    assert dates == ["2026-01-03", "2026-01-04", "2026-01-05"]
    assert offsets.use("2026-01-03")["offset"]["l_arm_ft"] == [2.0] * 6
    with pytest.raises(StoreError, match="got '2026-01'; it may be"):
        offsets.use("2026-01")
    with pytest.raises(StoreError, match="got '2025'"):
        offsets.use("2025")


def test_revert_goes_back_to_zero_and_no_further(offsets):
    found(offsets, 1.0)
    found(offsets, 2.0)
    assert offsets.revert()["offset"]["l_arm_ft"] == [1.0] * 6
    assert offsets.revert()["offset"]["l_arm_ft"] == [0.0] * 6
    assert offsets.status()["date"] == ""
    with pytest.raises(ValueError, match="nothing to revert"):
        offsets.revert()


def test_what_was_in_force_last_is_loaded_when_asked_for(offsets, tmp_path):
    first = found(offsets, 1.0)
    found(offsets, 2.0)
    offsets.revert()
    again = Offsets(TorqueObserver(ROBOT), OffsetStore(ROBOT, 3, tmp_path))
    assert again.status()["loaded"] == "not asked for"
    again.load()
    assert again.status()["loaded"] == f"offsets of {first.date}"
    np.testing.assert_array_equal(again._observer.offset, np.ones((K, 6)))


@pytest.mark.parametrize(
    ("key", "value", "text"),
    [("robot", "talos", "of robot talos"), ("model", "00000000", "model 00000000; this is icub")],
)
def test_offsets_of_another_robot_or_model_are_refused(offsets, tmp_path, key, value, text):
    date = found(offsets, 1.0).date
    offsets.revert()
    changed(tmp_path, lambda content: content["tares"][0].update({key: value}))
    with pytest.raises(StoreError, match=text):
        offsets.use(date)
    changed(tmp_path, lambda content: content.update(in_use=date))
    offsets.load()
    assert text in offsets.status()["loaded"]
    assert not offsets._observer.offset.any()


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (b"\xff{", "json"),
        (b'{"version": 2}', "version"),
        (b'{"wishes": {}}', "wishes: extra inputs"),
        (b'{"tares": [{"date": "x"}]}', r"tares.0.robot: field required"),
    ],
)
def test_a_foreign_file_is_an_error_is_left_alone_and_stops_no_tare(
    offsets, tmp_path, content, text
):
    file_of(tmp_path).write_bytes(content)
    with pytest.raises(StoreError, match=f"icub.json: .*{text}.*; move it away"):
        offsets.listed()
    found(offsets, 3.0)
    assert offsets.error.startswith("not stored: ") and (offsets._observer.offset == 3.0).all()
    offsets.load()
    assert offsets.loaded.startswith("refused: ")
    assert file_of(tmp_path).read_bytes() == content


def test_a_folder_that_cannot_be_made_is_said(tmp_path):
    (tmp_path / "file").write_text("")
    offsets = Offsets(TorqueObserver(ROBOT), OffsetStore(ROBOT, 3, tmp_path / "file"))
    found(offsets, 1.0)
    assert "not stored: " in offsets.error and offsets.revert()["message"].count("not stored") == 1
