"""Results of runs, one JSON line each, appended as they come: an interrupted benchmark goes on."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from experiments.touch.conditions import Condition

FILE = "touch.jsonl"
Record = dict[str, Any]


class Item(NamedTuple):
    """One run: a push (or two at once), or some contact-free motion."""

    what: str  # push or free
    seed: int
    index: int
    condition: Condition

    @property
    def labels(self) -> Record:
        named = {"what": self.what, "seed": self.seed, "index": self.index}
        return named | self.condition._asdict()


class Store:
    """The records of a folder; without a folder they are only remembered.

    Raises:
        ValueError: A line of the file is not a record.
    """

    def __init__(self, folder: Path | None):
        self._path = None if folder is None else folder / FILE
        self._records: dict[Item, Record] = {}
        if self._path is not None and self._path.exists():
            self._read(self._path)

    def _read(self, path: Path) -> None:
        lines = path.read_text().splitlines()
        for number, line in enumerate(lines, 1):
            try:
                record = json.loads(line)
                self._records[_item(record)] = record
            except (ValueError, KeyError, TypeError):
                if number == len(lines):  # cut off while it was written
                    path.write_text("".join(f"{whole}\n" for whole in lines[:-1]))
                    return
                raise ValueError(f"{path}: line {number} is not a result of a run") from None

    def missing(self, items: Iterable[Item]) -> list[Item]:
        """Return the runs of which there is no result yet."""
        return [item for item in items if item not in self._records]

    def add(self, item: Item, score: Record) -> None:
        record = item.labels | score
        self._records[item] = record
        if self._path is not None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with self._path.open("a") as file:
                file.write(json.dumps(record, separators=(",", ":")) + "\n")

    def records(self, what: str) -> list[Record]:
        """Return all results of a kind, in an order that does not depend on when they came."""
        found = [item for item in self._records if item.what == what]
        return [self._records[item] for item in sorted(found)]


def _item(record: Record) -> Item:
    condition = Condition(*(record[name] for name in Condition._fields))
    return Item(record["what"], record["seed"], record["index"], condition)
