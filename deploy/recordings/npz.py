"""A recording as arrays: one npz with every field of the chosen ports."""

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy

from bus.described_type import is_array
from bus.recording import Port
from deploy.recordings.columns import Column, Texts, save_into
from deploy.recordings.selection import Item, Selection
from robot_model import Robot

NUMBERS = ("seq", "stamp", "acquired", "sent")  # of the envelope
PLAIN = {"float": float, "int": np.int64, "bool": bool}


class _Table:
    """The arrays of one port: its fields, and what the envelopes say."""

    def __init__(self, port: Port):
        self._fields: dict[str, Column | Texts] = {
            field["name"]: _column(field) for field in port.fields
        }
        self._numbers = {name: Column(np.int64) for name in NUMBERS}
        self._valid, self._reason = Column(bool), Texts()

    def add(self, item: Item) -> None:
        envelope = item.envelope
        for name, column in self._numbers.items():
            column.add(getattr(envelope, name))
        self._valid.add(envelope.valid)
        self._reason.add(envelope.reason)
        for name, column in self._fields.items():
            column.add(getattr(item.message, name))

    def save(self, archive: zipfile.ZipFile, folder: str) -> None:
        flags = {"message_valid": self._valid, "message_reason": self._reason}
        for name, column in {**self._numbers, **flags, **self._fields}.items():
            save_into(archive, f"{folder}{name}", column.save)


def _column(field: dict[str, Any]) -> Column | Texts:
    if is_array(field):
        return Column(float if field["type"] == "float64" else bool)
    kind = PLAIN.get(field["type"])
    return Column(kind) if kind else Texts()


def export_npz(selection: Selection, robots: Mapping[str, Robot], out: Path) -> dict[str, int]:
    """Write the arrays ``<port without its leading slash>/<field>``; return messages per port.

    Besides the fields each port has ``seq``, ``stamp``, ``acquired``, ``sent`` [ns],
    ``message_valid`` and ``message_reason``. ``joint_names``, ``ft_sensors`` and ``imus``
    say what the rows are.
    """
    tables = {port.name: _Table(port) for port in selection.ports}
    counts = dict.fromkeys(tables, 0)
    for item in selection.items():
        tables[item.port.name].add(item)
        counts[item.port.name] += 1
    with zipfile.ZipFile(out, "w") as archive:
        for name, table in tables.items():
            table.save(archive, f"{name[1:]}/")
        for name, texts in _names(robots).items():
            save_into(archive, name, lambda file, texts=texts: npy.write_array(file, texts))
    return counts


def _names(robots: Mapping[str, Robot]) -> dict[str, np.ndarray]:
    if len(robots) != 1:
        return {}
    robot = next(iter(robots.values()))
    names = {"joint_names": robot.joints, "ft_sensors": robot.ft_sensors, "imus": robot.imus}
    return {key: np.array(value, dtype=str) for key, value in names.items()}
