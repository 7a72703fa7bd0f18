"""The command as a process, with a runtime directory of its own."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from bus import Node
from bus.testing import Process, eventually, running_hub, wait_for_service
from deploy.main import run

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


class Result(NamedTuple):
    """What one verb did."""

    status: int
    out: str
    err: str

    @property
    def documents(self) -> list[Any]:
        """The JSON documents on its standard output."""
        return [json.loads(line) for line in self.out.splitlines()]


@pytest.fixture(scope="session")
def toy_bus() -> Iterator[str]:
    """Endpoint of a bus with a toy on it (`tests.bus.toys`), and no robot."""
    with running_hub() as endpoint:
        toy = Process("tests.bus.toys", "--connect", endpoint)
        try:
            with Node("watcher", connect=endpoint, signals=False) as watcher:
                wait_for_service(watcher, "toy", timeout=60.0)
            yield endpoint
            assert toy.stop() == 0
        finally:
            toy.clean_up()


@pytest.fixture
def verb(toy_bus: str, capsys: pytest.CaptureFixture[str]) -> Callable[..., Result]:
    """Return ``verb(*arguments)``, which runs a verb on the toy's bus, in this process."""

    def ran(*arguments: str) -> Result:
        capsys.readouterr()
        status = run([*arguments[:1], "--connect", toy_bus, *arguments[1:]])
        return Result(status, *capsys.readouterr())

    return ran


@pytest.fixture
def typed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], None]]:
    """Return ``typed(text)``, which makes a text the standard input."""
    with ExitStack() as files:

        def type_in(text: str) -> None:
            file = tmp_path / "typed"
            file.write_text(text)
            monkeypatch.setattr("sys.stdin", files.enter_context(file.open()))

        yield type_in
