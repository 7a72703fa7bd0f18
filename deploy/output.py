"""Tables for people and JSON for programs, both on standard output."""

import json
import os
import select
import sys
from collections.abc import Sequence
from typing import Any

import typer

from deploy.errors import CommandError


def print_json(value: Any) -> None:
    """Print one JSON document on one line, at once."""
    print_line(json.dumps(value, default=_plain, allow_nan=False))


def print_table(rows: Sequence[dict[str, Any]], columns: Sequence[str]) -> None:
    """Print rows as an aligned table without wrapping, so that it can be piped to grep."""
    for line in table_lines(rows, columns):
        print_line(line)


def table_lines(rows: Sequence[dict[str, Any]], columns: Sequence[str]) -> list[str]:
    """Return the lines of an aligned table, the names of the columns first."""
    cells = [[_text(row.get(column)) for column in columns] for row in rows]
    widths = [max(map(len, column)) for column in zip(columns, *cells, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in [list(columns), *cells]
    ]


def print_line(text: str) -> None:
    """Print one line at once; when nobody reads any more, the verb is done."""
    try:
        sys.stdout.write(text + "\n")
        sys.stdout.flush()
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or the exit complains
        if isinstance(error, BrokenPipeError):
            raise typer.Exit(0) from None
        raise CommandError(f"cannot write the output: {error.strerror}") from None


def print_warning(text: str) -> None:
    """Print one line on standard error; the verb goes on."""
    print(f"wrenchbus: {' '.join(text.split())}", file=sys.stderr, flush=True)


def reader_gone() -> bool:
    """Whether standard output is a pipe that nobody reads any more."""
    try:
        poll = select.poll()
        poll.register(sys.stdout.fileno(), 0)
        return any(event & select.POLLERR for _, event in poll.poll(0))
    except (OSError, ValueError):  # it is no file
        return False


def print_message(answer: dict[str, Any], title: str = "") -> None:
    """Print what a service says of what it did, each line behind a title."""
    for text in answer["message"].splitlines():
        print_line(f"{title}: {text}" if title else text)


def print_answer(value: Any) -> None:
    """Print an RPC answer for people: a map line by line, anything else on one line."""
    if not isinstance(value, dict):
        print_line(json.dumps(value, ensure_ascii=False))
        return
    for name, entry in value.items():
        text = entry if isinstance(entry, str) else json.dumps(entry, ensure_ascii=False)
        print_line(f"{name}: {text}")


def _plain(value: Any) -> Any:
    """Turn what JSON does not know into what it knows: arrays, bytes, tuples with names."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, bytes | memoryview):
        return bytes(value).hex()
    raise TypeError(f"cannot print {type(value).__name__} as JSON")


def _text(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list | tuple):
        return ", ".join(map(_text, value))
    return str(value)
