"""Arrays that grow message by message, kept in files until they are put into an npz."""

import json
import zipfile
from collections.abc import Callable
from tempfile import TemporaryFile
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy

BLOCK = 1 << 20  # bytes copied at a time


class Column:
    """One array in the making: (messages, …) of float64, bool or int64.

    Where the shape changes from message to message, or the value is missing, the array
    is as large as the largest and filled up with NaN (False in arrays of booleans).
    """

    def __init__(self, dtype: type):
        self._dtype = np.dtype(dtype)
        self._file: IO[bytes] = TemporaryFile()
        self._shapes: list[tuple[int, ...] | None] = []

    def add(self, value: Any) -> None:
        """Append one message's value; None where it has none."""
        if value is None:
            self._shapes.append(None)
            return
        array = np.asarray(value, dtype=self._dtype)
        self._shapes.append(array.shape)
        self._file.write(array.tobytes())

    def save(self, file: IO[bytes]) -> None:
        """Write the array as npy."""
        self._file.seek(0)
        shapes = {shape for shape in self._shapes if shape is not None}
        if len(shapes) > 1 or None in self._shapes:
            self._save_filled(file, _largest(shapes))
        else:
            self._header(file, next(iter(shapes), ()))
            while block := self._file.read(BLOCK):
                file.write(block)
        self._file.close()

    def _save_filled(self, file: IO[bytes], largest: tuple[int, ...]) -> None:
        self._header(file, largest)
        filler = np.nan if self._dtype.kind == "f" else 0
        for shape in self._shapes:
            row = np.full(largest, filler, self._dtype)
            if shape is not None:
                data = self._file.read(int(np.prod(shape)) * self._dtype.itemsize)
                part = tuple(slice(length) for length in shape)
                row[part] = np.frombuffer(data, self._dtype).reshape(shape)
            file.write(row.tobytes())

    def _header(self, file: IO[bytes], shape: tuple[int, ...]) -> None:
        full = (len(self._shapes), *shape)
        npy.write_array_header_1_0(
            file, {"descr": self._dtype.str, "fortran_order": False, "shape": full}
        )


class Texts:
    """Texts in the making; anything else is kept as JSON."""

    def __init__(self) -> None:
        self._texts: list[str] = []

    def add(self, value: Any) -> None:
        """Append one message's value."""
        self._texts.append(value if isinstance(value, str) else json.dumps(value))

    def save(self, file: IO[bytes]) -> None:
        """Write the array as npy."""
        npy.write_array(file, np.array(self._texts, dtype=str), allow_pickle=False)


def _largest(shapes: set[tuple[int, ...]]) -> tuple[int, ...]:
    return tuple(max(lengths) for lengths in zip(*shapes, strict=True))


def save_into(archive: zipfile.ZipFile, name: str, save: Callable[[IO[bytes]], None]) -> None:
    """Add an array to an npz."""
    with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
        save(file)
