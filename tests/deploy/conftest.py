"""The command as a process, with a runtime directory of its own."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from bus.testing import eventually

ROOT = Path(__file__).parents[2]


class Command:
    """A running ``wrenchbus`` command whose output goes to files."""

    def __init__(self, arguments: tuple[str, ...], folder: Path):
        self.files = [folder / f"{len(list(folder.iterdir()))}.{end}" for end in ("out", "err")]
        out, err = (file.open("w") for file in self.files)
        with out, err:
            self.popen = subprocess.Popen(
                [sys.executable, "-m", "deploy.main", *arguments],
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=err,
                cwd=ROOT,
                env=os.environ,
                start_new_session=True,
            )

    @property
    def output(self) -> str:
        """Standard output so far."""
        return self.files[0].read_text()

    @property
    def errors(self) -> str:
        """Standard error so far."""
        return self.files[1].read_text()

    def until(self, text: str, timeout: float = 200.0) -> None:
        """Wait for a text on standard output."""
        eventually(
            lambda: text in self.output, timeout, f"{text!r}, got {self.output}{self.errors}"
        )

    def end(self, timeout: float = 60.0) -> int:
        """Wait for the end; return the exit status."""
        return self.popen.wait(timeout)


@pytest.fixture
def runtime_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A runtime directory in which only this test's buses are found."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("WRENCHBUS_CONNECT", raising=False)
    return tmp_path / "wrenchbus"


@pytest.fixture
def launch(runtime_directory: Path, tmp_path: Path) -> Iterator[Callable[..., Command]]:
    """Return ``launch(*arguments)``, which starts a command; all are killed at the end."""
    folder = tmp_path / "output"
    folder.mkdir()
    started: list[Command] = []

    def run(*arguments: str) -> Command:
        started.append(Command(arguments, folder))
        return started[-1]

    yield run
    for command in started:
        command.popen.kill()
        command.popen.wait()


@pytest.fixture
def application(tmp_path: Path) -> Callable[[str], str]:
    """Return ``application(yaml)``, which writes an application file and returns its path."""

    def write(text: str) -> str:
        file = tmp_path / "application.yaml"
        file.write_text(text)
        return str(file)

    return write
