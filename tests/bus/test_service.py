"""The frame of a service: command line, settings, exit status."""

import signal
import subprocess
import sys

import pytest

from bus.introspection import port_info
from bus.testing import eventually
from tests.bus.messages import Number

TOY = [sys.executable, "-m", "tests.bus.toys"]


def run(*arguments):
    return subprocess.run([*TOY, *arguments], capture_output=True, text=True, timeout=120)


def test_help_shows_the_options_and_an_example():
    result = run("--help")
    assert result.returncode == 0
    for option in ("--name", "--params", "--set", "-e", "-l", "-c", "--namespace", "--log-level"):
        assert option in result.stdout
    assert "example: python -m" in result.stdout


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (
            ("--set", "factr=3"),
            "toy: --set factr=3: factr: unknown key (did you mean factor?); there",
        ),
        (
            ("--set", "factor=0"),
            "toy: --set factor=0: factor: Input should be greater than 0, got 0",
        ),
        (("--set", "factor=abc"), "factor: Input should be a valid number"),
        (("--set", "factor"), "toy: --set: expected KEY=VALUE, got 'factor'"),
        (("--params", "/nowhere.yaml"), "toy: /nowhere.yaml: No such file or directory"),
    ],
)
def test_a_wrong_setting_ends_with_two_and_one_line(arguments, complaint):
    result = run(*arguments)
    assert (result.returncode, result.stdout) == (2, "")
    assert complaint in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_wrong_file_is_named(tmp_path):
    file = tmp_path / "toy.yaml"
    file.write_text("rate: fast\n")
    result = run("--params", str(file))
    assert result.returncode == 2
    assert result.stderr.startswith(f"toy: {file}: rate: Input should be a valid number")
    file.write_text("rate: [1\n")
    assert str(file) in run("--params", str(file)).stderr


def test_a_wrong_option_ends_with_two():
    result = run("--nonsense")
    assert result.returncode == 2 and "usage:" in result.stderr
    result = run("--log-level", "loud")
    assert result.returncode == 2 and "choose from 'debug', 'info'" in result.stderr


def test_a_service_that_cannot_work_ends_with_one_and_one_line(hub):
    result = run("--connect", hub, "--set", "fail=unknown joint l_elbo")
    assert (result.returncode, result.stderr) == (1, "toy: unknown joint l_elbo\n")


def test_a_service_without_a_bus_says_how_to_start_one(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    result = run()
    assert result.returncode == 1
    assert "no bus is running" in result.stderr and result.stderr.count("\n") == 1


def test_a_service_takes_its_name_its_settings_and_its_namespace(start, node, hub):
    toy = start(
        "tests.bus.toys",
        *("--name", "twin", "--set", "factor=3", "--set", "output=/twin/out:o"),
    )
    assert node.call("/twin/rpc:i", "param", {"action": "get", "name": "factor"}) == 3.0
    assert node.call("/twin/rpc:i", "status")["pid"] == toy.pid


def test_a_service_doubles_what_comes_and_marks_its_output_when_nothing_comes(start, node):
    start("tests.bus.toys", service="toy")
    out = node.output("/test/out:o", Number, rate=100.0)
    inp = node.input("/test/in:i", Number, source="/toy/out:o", depth=256, rate=100.0)
    node.ready()
    seen = lambda: (node.wait(0.02), inp.newest())[1] and inp.latest  # noqa: E731
    first = eventually(seen)
    assert not first.envelope.valid and "/test/out:o" in first.envelope.reason

    def answered():
        out.write(Number(value=4.0))
        received = seen()
        return received and received.envelope.valid and received.data.value == 8.0

    eventually(answered)
    eventually(lambda: (got := seen()) and not got.envelope.valid)
    assert inp.latest.envelope.reason.startswith("no data on /test/out:o for ")


def test_parameters_are_set_over_rpc_and_validated(start, node):
    start("tests.bus.toys", service="toy")

    def param(action, **more):
        return node.call("/toy/rpc:i", "param", {"action": action, **more})

    assert param("list")["factor"] == 2.0
    assert param("set", name="factor", value=5) == 5.0
    with pytest.raises(Exception, match="factor: Input should be greater than 0, got -1"):
        param("set", name="factor", value=-1)
    with pytest.raises(Exception, match=r"unknown parameter 'factr' \(did you mean factor\?\)"):
        param("set", name="factr", value=1)
    assert param("get", name="factor") == 5.0


def test_a_stopped_service_tells_about_its_ports_again_when_it_goes_on(start, node):
    toy = start("tests.bus.toys", service="toy")
    eventually(lambda: port_info(node, "/toy/out:o", 30.0)["statistics"]["written"] > 0)
    toy.send(signal.SIGSTOP)
    error = str(eventually(lambda: port_info(node, "/toy/out:o", timeout=0.3).get("error")))
    assert "no answer within 0.3 s" in error
    toy.send(signal.SIGCONT)
    eventually(lambda: "statistics" in port_info(node, "/toy/out:o", timeout=30.0))
