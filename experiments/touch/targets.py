"""The targets of the contact detector, and whether results reach them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import ge, le
from typing import NamedTuple

import numpy as np

from experiments.touch.figures import free_figures, push_figures, standing
from experiments.touch.motions import STANDING
from experiments.touch.store import Record
from experiments.touch.tables import Table

STRONG = 10.0  # N


class Value(NamedTuple):
    """A figure, of how many pushes or hours, and its unit."""

    number: float
    of: str
    unit: str


class Sensors(NamedTuple):
    """Profile and variant."""

    profile: str = "realistic"
    variant: str = "usual"


@dataclass(frozen=True)
class Target:
    """Bounds of one figure of the pushes of a standing robot."""

    name: str
    figure: str
    must: float
    goal: float
    unit: str = "%"
    sensors: Sensors = Sensors()
    least: float = 0.0  # N

    def value(self, pushes: Sequence[Record]) -> Value:
        mine = [record for record in pushes if self._counts(record)]
        number = push_figures(mine)[self.figure]
        number = 100.0 * number if self.unit == "%" else number
        return Value(number, f"{len(standing(mine))} pushes", self.unit)

    def _counts(self, record: Record) -> bool:
        same = Sensors(record["profile"], record["variant"]) == self.sensors
        strong = min(record["forces"]) >= self.least
        return same and strong and record["motion"] in STANDING


IDEAL = Sensors("ideal", "exact_masses")
TWELVE_BITS = Sensors("realistic_12bit")
CALIBRATED = Sensors(variant="calibrated")
CALIBRATED_TWELVE_BITS = Sensors("realistic_12bit", "calibrated")
CALIBRATED_IDEAL = Sensors("ideal", "exact_masses_calibrated")
TARGETS = (
    Target("detected from 10 N on", "detected", 99, 100, least=STRONG),
    Target("delay from 10 N on, median", "delay", 15, 6, "ms", least=STRONG),
    Target("link first", "first", 88, 95),
    Target("link among three", "among_three", 99, 100),
    Target("point, median", "point", 8, 4, "mm"),
    Target("point, 90 %", "point_90", 25, 15, "mm"),
    Target("force, median", "force", 0.5, 0.25, "N"),
    Target("12 bit: link first", "first", 86, 95, sensors=TWELVE_BITS),
    Target("12 bit: point, median", "point", 8, 4, "mm", sensors=TWELVE_BITS),
    Target("12 bit: delay, median", "delay", 30, 6, "ms", sensors=TWELVE_BITS),
    Target(
        "two contacts, different sub-graphs: right pair",
        "first",
        75,
        90,
        sensors=Sensors(variant="apart"),
    ),
    Target("ideal: link first", "first", 99, 99, sensors=IDEAL),
    Target("ideal: point, median", "point", 1, 1, "mm", sensors=IDEAL),
    Target("calibrated: link first", "first", 88, 95, sensors=CALIBRATED),
    Target("calibrated: point, median", "point", 8, 4, "mm", sensors=CALIBRATED),
    Target("calibrated, 12 bit: link first", "first", 86, 95, sensors=CALIBRATED_TWELVE_BITS),
    Target("calibrated, ideal: link first", "first", 99, 99, sensors=CALIBRATED_IDEAL),
    Target("calibrated, ideal: point, median", "point", 1, 1, "mm", sensors=CALIBRATED_IDEAL),
)


def target_table(pushes: Sequence[Record], free: Sequence[Record], method: str) -> Table:
    """Return what was to be reached and what was, by one method."""
    mine = [record for record in pushes if record["method"] == method]
    rows = [_row(target.name, target.must, target.goal, target.value(mine)) for target in TARGETS]
    usual = [record for record in free if (record["profile"], record["variant"]) == Sensors()]
    figures = free_figures(usual)
    alarms = Value(figures["per_hour"], f"{figures['hours']:.2g} h", "/h")
    rows.insert(2, _row("false alarms in motion", 1.0, 0.0, alarms))
    header = ("", "must", "goal", "reached", "of", "verdict")
    title = f"Targets ({method}; standing, swaying, moving the upper body)"
    return Table(title, header, rows)


def _row(name: str, must: float, goal: float, value: Value) -> tuple[str, ...]:
    better: Callable[[float, float], bool] = ge if value.unit == "%" else le
    cells = (f"{number:.3g} {value.unit}" for number in (must, goal, value.number))
    if not np.isfinite(value.number):
        return name, *list(cells)[:2], "-", value.of, "not measured"
    verdict = "goal" if better(value.number, goal) else "must"
    return name, *cells, value.of, verdict if better(value.number, must) else "missed"
