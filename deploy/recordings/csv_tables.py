"""A recording as tables: a folder with one CSV file per port, units in the header."""

import csv
import json
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from bus.described_type import is_array
from bus.recording import Port
from deploy.recordings.labels import Labels, unit_at
from deploy.recordings.selection import Item, Selection
from robot_model import Robot

HEAD = ("seq", "stamp [ns]", "acquired [ns]", "sent [ns]", "message_valid", "message_reason")


def export_csv(selection: Selection, robots: Mapping[str, Robot], out: Path) -> dict[str, int]:
    """Write ``<port with _ for />.csv`` for every port; return messages per port."""
    out.mkdir(parents=True, exist_ok=True)
    labels = Labels(robots)
    return {port.name: _write(selection, port, labels, out) for port in selection.ports}


def file_name(port: str) -> str:
    """Return the name of a port's table."""
    return port[1:].replace("/", "_").replace(":", "_") + ".csv"


def _write(selection: Selection, port: Port, labels: Labels, out: Path) -> int:
    rows = _Rows(port, labels)
    columns = rows.columns(selection.items([port]))
    count = 0
    with (out / file_name(port.name)).open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow([*HEAD, *columns])
        for item in selection.items([port]):
            cells = rows.cells(item)
            writer.writerow([*_head(item), *(cells.get(column, "") for column in columns)])
            count += 1
    return count


def _head(item: Item) -> tuple:
    envelope = item.envelope
    times = envelope.stamp, envelope.acquired, envelope.sent
    return (envelope.seq, *times, int(envelope.valid), envelope.reason)


class _Rows:
    """Turns messages of one port into cells by column."""

    def __init__(self, port: Port, labels: Labels):
        self._fields = port.fields
        self._labels = labels
        self._headers: dict[tuple, list[str]] = {}

    def columns(self, items: Iterator[Item]) -> list[str]:
        """Return the columns that any message has; where shapes are fixed the first tells."""
        found: dict[str, None] = {}
        fixed = all(_is_fixed(field) for field in self._fields)
        for item in items:
            found |= dict.fromkeys(self.cells(item))
            if fixed:
                break
        return list(found)

    def cells(self, item: Item) -> dict[str, Any]:
        """Return the values of one message by column."""
        cells: dict[str, Any] = {}
        for field in self._fields:
            value = getattr(item.message, field["name"])
            if value is None:
                continue
            if is_array(field):
                names = self._names(field, value, item)
                flat = value.astype(int) if value.dtype == bool else value
                cells |= zip(names, flat.ravel().tolist(), strict=True)
            else:
                cells[_header(field["name"], field["unit"])] = _plain(value)
        return cells

    def _names(self, field: dict[str, Any], value: np.ndarray, item: Item) -> list[str]:
        axes = self._labels.of(field, value.shape, item.message, item.envelope.model)
        key = (field["name"], *axes)
        if key not in self._headers:
            indices = product(*map(range, value.shape))
            units = [unit_at(field, index) for index in indices]
            names = [".".join([field["name"], *entry]) for entry in product(*axes)]
            self._headers[key] = list(map(_header, names, units))
        return self._headers[key]


def _is_fixed(field: dict[str, Any]) -> bool:
    """Whether a field always has the same columns: the robot's dimensions do not change."""
    named = [dim for dim in field["shape"] if isinstance(dim, str)]
    return not field["optional"] and set(named) <= set("nkm")


def _header(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit not in ("", "1") else name


def _plain(value: Any) -> Any:
    if isinstance(value, bool):
        return int(value)
    return value if isinstance(value, int | float | str) else json.dumps(value)
