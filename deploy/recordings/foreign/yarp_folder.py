"""What yarpdatadumper writes: a folder per port with ``data.log`` and ``info.log``.

A line of ``data.log`` is ``number time [time] Bottle``: the sender's stamp, the receiver's, or
both (sender's first), as ``info.log`` says in its line ``Stamp: tx+rx;``.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from bus.names import did_you_mean
from deploy.errors import UsageError
from deploy.recordings.foreign.bottle import BottleError, parse
from deploy.recordings.foreign.map_file import LogMap, Stream
from deploy.recordings.foreign.problems import Problems
from deploy.recordings.foreign.samples import Samples
from deploy.recordings.foreign.tracks import Track, tracks_of
from robot_model import Robot

STAMP = re.compile(r"^Stamp:\s*([a-z+]+)", re.MULTILINE)
TYPE = re.compile(r"^Type:\s*([A-Za-z:]+)", re.MULTILINE)
CONNECTED = re.compile(r"^\[[^\]]*\]\s+(/\S+)\s+\[connected\]", re.MULTILINE)
NEAR = 60.0  # s; two stamps of one message differ by less
EPOCH = 1e8  # s; smaller numbers are no wall time


class YarpLog:
    """A tree of folders; raises UsageError when there is no data.log in it."""

    def __init__(self, folder: Path):
        self._root = folder
        self._folders = sorted(file.parent for file in folder.rglob("data.log"))
        if not self._folders:
            raise UsageError(f"{folder}: no data.log in it; is it a folder of yarpdatadumper?")
        self._infos = {path: _read(path / "info.log") for path in self._folders}
        self._ports = {
            port: path for path in self._folders for port in CONNECTED.findall(self._infos[path])
        }

    def tracks(self, log_map: LogMap, robot: Robot, problems: Problems) -> list[Track]:
        """Return all streams of a map; raise UsageError when one is not there."""
        found = []
        for stream in log_map.streams:
            times, values = self._read(stream, log_map, problems)
            found += tracks_of(stream, times, values, robot)
        return found

    def _folder(self, source: str) -> Path:
        path = self._root / source.lstrip("/")
        if path in self._folders:
            return path
        if source in self._ports:
            return self._ports[source]
        known = [str(path.relative_to(self._root)) for path in self._folders] + [*self._ports]
        hint = did_you_mean(source, known) or f" (it has {', '.join(known)})"
        raise UsageError(f"{self._root}: no stream {source!r}{hint}")

    def _read(
        self, stream: Stream, log_map: LogMap, problems: Problems
    ) -> tuple[np.ndarray, np.ndarray]:
        folder = self._folder(stream.source)
        file, info = folder / "data.log", self._infos[folder]
        samples = Samples(file, stream.width, problems)
        if (kind := TYPE.search(info)) and kind[1] != "Bottle":
            problems.warn(f"{file}: holds {kind[1]}, expected Bottle; nothing is read from it")
            return samples.arrays()
        stamps = _stamps(info, file)
        taken = 0 if stamps == 1 or log_map.stamps == "sent" else 1
        for number, line in _lines(file):
            try:
                times, values = _split(line, stamps)
                samples.add(number, times[taken], _inside(values, stream.inside))
            except (BottleError, ValueError) as error:
                problems.line(file, number, "malformed", str(error))
        times, numbers = samples.arrays()
        if not len(times):
            problems.warn(f"{file}: no line of it could be used")
        return times, numbers


def _read(path: Path) -> str:
    try:
        return path.read_text(errors="replace")
    except OSError:
        return ""


def _lines(file: Path) -> Iterator[tuple[int, str]]:
    with file.open(errors="replace") as lines:
        for number, line in enumerate(lines, start=1):
            if line.strip():
                yield number, line


def _stamps(info: str, file: Path) -> int:
    """Return how many stamps a line has; where info.log does not say, as the lines look."""
    if said := STAMP.search(info):
        return 2 if said[1] == "tx+rx" else 1
    for _, line in _lines(file):
        words = line.split(maxsplit=3)
        try:
            first, second = float(words[1]), float(words[2])
        except (IndexError, ValueError):
            continue
        return 2 if first > EPOCH and abs(second - first) < NEAR else 1
    return 1


def _split(line: str, stamps: int) -> tuple[list[float], list[Any]]:
    words = line.split(maxsplit=1 + stamps)
    if len(words) < 2 + stamps:
        raise ValueError("the line is too short")
    int(words[0])
    return [float(word) for word in words[1 : 1 + stamps]], parse(words[-1])


def _inside(values: list[Any], path: list[int]) -> list[Any]:
    for index in path:
        if index >= len(values) or not isinstance(values[index], list):
            raise ValueError(f"no list at position {index}")
        values = values[index]
    return values
