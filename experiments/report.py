"""What an experiment found: figures for programs, lines for people, files for documents."""

import csv
import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass(frozen=True, eq=False)
class Report:
    """The result of an experiment."""

    name: str
    figures: dict[str, Any]  # what JSON can say; numbers that are not finite become null
    lines: list[str]
    files: Mapping[str, str] = field(default_factory=dict)  # contents, by file name

    @property
    def document(self) -> dict[str, Any]:
        return _finite(self.figures)

    def write(self, folder: Path) -> list[Path]:
        """Write ``<name>.json`` and the other files; return their paths."""
        folder.mkdir(parents=True, exist_ok=True)
        text = json.dumps(self.document, indent=1, allow_nan=False) + "\n"
        contents = {f"{self.name}.json": text, **self.files}
        for file, content in contents.items():
            (folder / file).write_text(content)
        return [folder / file for file in contents]


def csv_text(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Return a table as CSV; numbers with six digits."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(header)
    for row in rows:
        writer.writerow([f"{x:.6g}" if isinstance(x, float) else x for x in row])
    return buffer.getvalue()


def markdown_table(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Return a table as Markdown; numbers with three decimals."""
    cells = [[f"{x:.3f}" if isinstance(x, float) else str(x) for x in row] for row in rows]
    lines = [header, ["---"] * len(header), *cells]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def text_table(title: str, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> list[str]:
    """Return a table as lines of aligned columns; numbers with three digits."""
    cells = [[f"{x:.3g}" if isinstance(x, float) else str(x) for x in row] for row in rows]
    columns = list(zip(header, *cells, strict=True))
    widths = [max(map(len, column)) for column in columns]
    first, *others = ([cell.ljust(w) for cell in c] for c, w in zip(columns, widths, strict=True))
    right = [[cell.strip().rjust(w) for cell in c] for c, w in zip(others, widths[1:], strict=True)]
    return [title, *("  ".join(row).rstrip() for row in zip(first, *right, strict=True)), ""]


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
