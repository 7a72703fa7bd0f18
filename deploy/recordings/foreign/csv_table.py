"""A table with a header, a column of times and columns of numbers."""

import csv
from collections.abc import Sequence
from pathlib import Path

from bus.names import did_you_mean
from deploy.errors import UsageError
from deploy.recordings.foreign.map_file import LogMap, Stream
from deploy.recordings.foreign.problems import Problems
from deploy.recordings.foreign.samples import Samples
from deploy.recordings.foreign.tracks import Track, tracks_of
from robot_model import Robot

NANOSECONDS = {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1.0}


def csv_tracks(file: Path, log_map: LogMap, robot: Robot, problems: Problems) -> list[Track]:
    """Return the streams of a map, read from a CSV file.

    Rows in which all columns of a stream are empty or NaN are no samples of it.

    Raises:
        UsageError: The file cannot be read, or a column of the map is not there.
    """
    if log_map.time is None:
        raise UsageError("the map names no time column; expected time: {column: ..., unit: s}")
    try:
        with file.open(newline="", errors="replace") as lines:
            reader = csv.reader(_without_nul(lines))
            header = [name.strip() for name in next(reader, [])]
            time_at = _positions([log_map.time.column], header, file)[0]
            streams = [_Reader(s, header, file, problems) for s in log_map.streams]
            for row in reader:
                if any(row):
                    _take(row, reader.line_num, time_at, log_map.time.unit, streams, problems, file)
    except (OSError, csv.Error) as error:
        raise UsageError(f"{file}: {error}") from None
    return [track for stream in streams for track in stream.tracks(robot)]


def _without_nul(lines):
    return (line.replace("\0", "?") for line in lines)


def _take(
    row: list[str],
    line: int,
    time_at: int,
    unit: str,
    streams: Sequence["_Reader"],
    problems: Problems,
    file: Path,
) -> None:
    try:
        text = row[time_at].strip()
        time = int(text) if unit == "ns" else round(float(text) * NANOSECONDS[unit])
    except (IndexError, ValueError, OverflowError):
        problems.line(file, line, "no time stamp", ",".join(row))
        return
    for stream in streams:
        stream.add(line, time, row)


class _Reader:
    """One stream of the table."""

    def __init__(self, stream: Stream, header: list[str], file: Path, problems: Problems):
        if len(stream.columns) < stream.width:
            expected = f"expected {stream.width} columns for {stream.target}"
            raise UsageError(f"{file}: {expected}, got {stream.columns}")
        self._stream, self._file, self._problems = stream, file, problems
        self._at = _positions(stream.columns, header, file)
        self._samples = Samples(file, stream.width, problems)

    def add(self, line: int, time: int, row: list[str]) -> None:
        if len(row) <= max(self._at):
            self._problems.line(self._file, line, "malformed", f"it has {len(row)} columns")
            return
        cells = [row[index].strip() for index in self._at]
        if all(cell.lower() in ("", "nan") for cell in cells):
            return
        try:
            self._samples.add(line, time, [float(cell) for cell in cells])
        except ValueError as error:
            self._problems.line(self._file, line, "malformed", str(error))

    def tracks(self, robot: Robot) -> list[Track]:
        return tracks_of(self._stream, *self._samples.arrays(), robot)


def _positions(columns: Sequence[str], header: list[str], file: Path) -> list[int]:
    for name in columns:
        if name not in header:
            hint = did_you_mean(name, header) or f" (it has {', '.join(header[:40])})"
            raise UsageError(f"{file}: no column {name!r}{hint}")
    return [header.index(name) for name in columns]
