"""Live settings."""

import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from pydantic import BaseModel, ConfigDict, Field

from bus.configuration import ConfigurationError, load
from bus.parameters import Parameters
from bus.saved_settings import changes, save_settings


class Inner(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)
    gain: float = Field(default=1.0, ge=0.0)


class Outer(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)
    name: str = "arm"
    inner: Inner = Inner()
    joints: list[str] = []


def test_settings_have_dotted_names():
    parameters = Parameters(Outer())
    assert parameters.handle("list") == {"name": "arm", "inner.gain": 1.0, "joints": []}
    assert parameters.handle("set", "inner.gain", 4) == 4.0
    assert parameters.value.inner.gain == 4.0
    assert parameters.handle("get", "inner") == {"gain": 4.0}


def test_a_wrong_value_changes_nothing():
    parameters = Parameters(Outer())
    with pytest.raises(ValueError, match="inner.gain: Input should be greater than or equal to 0"):
        parameters.set("inner.gain", -1)
    with pytest.raises(LookupError, match="unknown parameter 'inner.gian'.*inner.gain"):
        parameters.set("inner.gian", 1)
    with pytest.raises(
        ValueError, match="expected action list, get, set, reset or save, got 'drop'"
    ):
        parameters.handle("drop")
    assert parameters.value == Outer()


def test_listeners_hear_of_a_change_and_may_refuse_it():
    parameters, heard = Parameters(Outer()), []

    def listen(old, new):
        heard.append((old.name, new.name))
        if new.name == "bad":
            raise ValueError("not that one")

    parameters.on_change(listen)
    parameters.set("name", "leg")
    with pytest.raises(ValueError, match="not that one"):
        parameters.set("name", "bad")
    assert heard == [("arm", "leg"), ("leg", "bad")]
    assert parameters.value.name == "leg"


def test_reset_returns_to_what_the_configuration_said():
    parameters = Parameters(Outer(inner=Inner(gain=2.0)))
    parameters.set("inner.gain", 4.0)
    parameters.set("name", "leg")
    assert parameters.handle("reset", "inner.gain") == 2.0
    assert parameters.handle("reset", "name") == "arm"
    with pytest.raises(LookupError, match="unknown parameter 'inner.gian'"):
        parameters.handle("reset", "inner.gian")


def test_saved_changes_are_settings_that_give_the_same_again(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    parameters = Parameters(Outer(inner=Inner(gain=2.0)))
    parameters.set("inner.gain", 4.0)
    said = save_settings("toy", parameters)
    assert said["file"] == str(tmp_path / "wrenchbus" / "settings" / "toy.yaml")
    assert yaml.safe_load(Path(said["file"]).read_text()) == {"inner": {"gain": 4.0}}
    assert load(Outer, None, said["file"]) == parameters.value


def test_a_setting_that_went_back_to_the_default_is_saved_too():
    parameters = Parameters(Outer(inner=Inner(gain=2.0), joints=["a"]))
    assert changes(parameters) == {"inner": {"gain": 2.0}, "joints": ["a"]}
    parameters.set("inner.gain", 1.0)
    assert changes(parameters) == {"inner": {"gain": 1.0}, "joints": ["a"]}


def test_a_node_without_settings_says_so():
    parameters = Parameters()
    assert parameters.handle("list") == {} and changes(parameters) == {}
    with pytest.raises(LookupError, match="unknown parameter 'gain'; there are: none"):
        parameters.set("gain", 1.0)


def test_the_hub_for_which_all_others_wait_starts_without_what_settings_need():
    told = "import sys, bus.hub; print({'pydantic', 'yaml'} & {*sys.modules})"
    done = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_layers_of_settings_lie_over_each_other(tmp_path):
    file = tmp_path / "x.yaml"
    file.write_text("name: leg\ninner: {gain: 2}\n")
    settings = load(Outer, None, file, ["inner.gain=3", "joints=[a, b]"])
    assert settings == Outer(name="leg", inner=Inner(gain=3.0), joints=["a", "b"])


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (
            "gain: 1\n",
            "x.yaml: gain: unknown key .did you mean inner.gain.*; there are: name, inner.gain",
        ),
        ("inner: {gian: 1}\n", "x.yaml: inner.gian: unknown key"),
        ("inner: {gain: x}\n", "x.yaml: inner.gain: Input should be a valid number.*got 'x'"),
        ("- 1\n", "x.yaml: expected KEY: VALUE lines"),
        ("name: [\n", "x.yaml: while parsing"),
    ],
)
def test_a_fault_names_file_key_and_what_exists(tmp_path, text, complaint):
    file = tmp_path / "x.yaml"
    file.write_text(text)
    with pytest.raises(ConfigurationError, match=complaint):
        load(Outer, None, file)
