"""docs/own_service.md: its files work, its commands run, its tests pass."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from bus.testing import free_port

PAGE = Path(__file__).parents[2] / "docs" / "own_service.md"
BIN = Path(sys.executable).parent


def blocks(language: str) -> list[str]:
    """Return the page's blocks of a language, in order."""
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)


@pytest.fixture
def project(tmp_path):
    """A folder with the files of the page."""
    service, main, test = blocks("python")
    config, laboratory = blocks("yaml")
    files = {
        "smoother/service.py": service,
        "smoother/__main__.py": main,
        "smoother/config.yaml": config,
        "test_smoother.py": test,
        "lab.yaml": laboratory,
    }
    (tmp_path / "smoother").mkdir()
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def run(project: Path, script: str) -> subprocess.CompletedProcess:
    """Run a script as somebody would type it, with a runtime directory of its own."""
    environment = {
        **{**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}", "PYTHONPATH": str(project)},
        **{"XDG_RUNTIME_DIR": str(project), "XDG_STATE_HOME": str(project)},
    }
    environment.pop("WRENCHBUS_CONNECT", None)
    command = ["bash", "-c", f"set -ex; trap 'kill $(jobs -p)' EXIT; {script}"]
    return subprocess.run(
        command, cwd=project, env=environment, capture_output=True, text=True, timeout=300
    )


def test_the_users_service_answers_the_commands_of_the_page(project):
    script = blocks("sh")[0].replace("bus.hub", f"bus.hub --listen tcp/127.0.0.1:{free_port()}")
    result = run(project, script)
    assert result.returncode == 0, result.stdout + result.stderr
    for told in (
        *("settings are now source='/sensor/force:o' rate=50.0 time_constant=0.5", '"value":'),
        *("period_s", "overruns", "no data on /sensor/force:o"),
    ):
        assert told in result.stdout, f"{told}\n{result.stdout}"


def test_the_users_test_passes(project):
    result = run(project, blocks("sh")[1])
    assert "2 passed" in result.stdout, result.stdout + result.stderr
