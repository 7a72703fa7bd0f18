"""The table of outputs: what is alive, how fast, how old, how much was lost."""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from .html import AMBER, GREEN, GREY, RED
from .table import Cell, table

SLOW = 0.9  # of the nominal rate; slower is shown as slow
TITLES = ("output", "state", "Hz", "nominal", "age", "lost")
NOTE = (
    "Hz: as the writer counts. Age: since the measurement where this page reads the port, else"
    " since the writer was last seen to write. Lost: messages that its readers miss. Idle: nobody"
    " listens, so nothing is written; where all readers are content with 250 Hz, no more is."
)


class PortRow(NamedTuple):
    """One output port."""

    name: str
    service: str
    state: str  # alive, slow, silent, idle, "no answer"
    hz: float
    nominal: float  # [Hz], 0 when it is written now and then
    age: float | None  # [s] since it was written, None before the first time
    lost: int  # on the wire, at all its readers together


class Written:
    """When each output's counter of messages last rose."""

    def __init__(self) -> None:
        self._last: dict[tuple[str, int], tuple[int, float | None]] = {}

    def age(self, name: str, pid: int, count: int, now: float) -> float | None:
        """Return the seconds since the counter was last seen to rise; None if it never has."""
        before, at = self._last.get((name, pid), (0, None))
        if count > before:
            at = now
        self._last[name, pid] = count, at
        return None if at is None else now - at


def port_rows(ports: Iterable[Mapping[str, Any]], written: Written, now: float) -> list[PortRow]:
    """Return a row per output from what the ports tell of themselves (``port_info``)."""
    ports = list(ports)
    lost = _lost(ports)
    return [
        _row(port, written, now, lost.get(port["name"], 0))
        for port in ports
        if port["direction"] == "output"
    ]


def _lost(ports: Iterable[Mapping[str, Any]]) -> dict[str, int]:
    """Messages that inputs missed, by source; of several sources each gets the whole."""
    lost: dict[str, int] = {}
    for port in ports:
        for source in port["sources"]:
            lost[source] = lost.get(source, 0) + port.get("statistics", {}).get("lost", 0)
    return lost


def _row(port: Mapping[str, Any], written: Written, now: float, lost: int) -> PortRow:
    name, owner, nominal = port["name"], port["owner"], port["nominal_hz"]
    count = port.get("statistics", {}).get("written", 0)
    age = written.age(name, owner["pid"], count, now)
    hz = port.get("hz", 0.0)
    return PortRow(name, owner["service"], _state(port, hz, nominal), hz, nominal, age, lost)


def _state(port: Mapping[str, Any], hz: float, nominal: float) -> str:
    if "error" in port:
        return "no answer"
    wanted = port.get("wanted_hz", nominal)
    if nominal and not wanted and not hz:
        return "idle"
    if hz >= SLOW * wanted:
        return "alive"
    return "slow" if hz > 0.0 else "silent"


def port_table(rows: list[PortRow], ages: Mapping[str, float]) -> str:
    """Return the table; ``ages`` [s] of measurements, where the page reads a port itself."""
    return table("ports", TITLES, [_cells(row, ages.get(row.name, row.age)) for row in rows], NOTE)


def _cells(row: PortRow, age: float | None) -> list[Cell]:
    return [
        Cell(row.name, hint=row.service),
        Cell(row.state, {"alive": GREEN, "idle": GREY, "slow": AMBER}.get(row.state, RED)),
        Cell(f"{row.hz:.0f}"),
        Cell(f"{row.nominal:.0f}" if row.nominal else "-"),
        Cell(_age(age)),
        counted(row.lost),
    ]


def counted(number: int) -> Cell:
    """Return a count of what should not happen."""
    return Cell(str(number), AMBER if number else "")


def _age(age: float | None) -> str:
    if age is None:
        return "-"
    return f"{age * 1e3:.0f} ms" if age < 1.0 else f"{age:.0f} s"
