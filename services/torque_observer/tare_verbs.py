"""The verbs that change the offsets: tare, and what is stored of it."""

from functools import partial
from typing import Any

from bus import Node, Pending
from estimation.resting import RestingAverage, RestingMean
from estimation.tare import Tare, TareResult, stance_supports
from estimation.torque_observer import TorqueObserver
from robot_model import ports
from services.torque_observer.config import TareConfig
from services.torque_observer.offset_store import OffsetStore
from services.torque_observer.offsets import Offsets
from services.torque_observer.taring import Taring


class TareVerbs:
    """Answers ``tare``, ``tares``, ``use_tare`` and ``revert_tare``."""

    def __init__(self, node: Node, observer: TorqueObserver, config: TareConfig):
        self._observer, self._config = observer, config
        self.collecting = Taring()
        self._offsets = Offsets(observer, OffsetStore(observer.robot, config.kept))
        if config.load:
            self._offsets.load()
        node.verb("tare", self.tare, help="take off what the resting robot's F/T sensors misread")
        node.verb("tares", self._offsets.listed, help="list stored offsets")
        node.verb("use_tare", self._offsets.use, help="put the stored offsets of a date in force")
        node.verb("revert_tare", self._offsets.revert, help="undo the last tare or use_tare")

    def configure(self, config: TareConfig) -> None:
        """Take new settings; a tare that is running keeps its limits of rest."""
        self._config = config
        self._offsets.configure(config.kept)

    def tare(
        self, seconds: float | None = None, samples: int | None = None, stance: str = ""
    ) -> Pending:
        """Tare the sensors while the robot rests and only its supports touch it.

        Args:
            seconds: How long to average; else ``samples`` frames, by default the setting's.
            samples: How many complete frames.
            stance: What bears the robot (``pole``, ``floor``, ``l_sole``); the service's
                support when empty.
        """
        c, robot = self._config, self._observer.robot
        stance = stance or self._observer.support
        stance_supports(robot, stance)
        if seconds is not None and samples is not None:
            raise ValueError("expected seconds or samples, got both")
        count = 0 if seconds is not None else c.samples if samples is None else samples
        least = min(c.least_samples, count or c.least_samples)
        average = RestingAverage(robot.joints, c.still.limits(), robot.ft_sensors, least)
        length = count / ports.rate("sensors") if seconds is None else float(seconds)
        return self.collecting.begin(length, average, partial(self._solve, stance), count)

    def status(self) -> dict[str, Any]:
        """Return which offsets are in force, and whether stored ones are loaded."""
        return {"load": self._config.load, **self._offsets.status()}

    def _solve(self, stance: str, rest: RestingMean) -> dict[str, Any]:
        c, observer = self._config, self._observer
        solver = Tare(observer.graph, c.force_bias, c.moment_bias)
        result = solver.solve(rest, stance, observer.offset)
        result.check(observer.robot.ft_sensors, c.largest())
        record = self._offsets.found(result, rest, stance)
        answer = _reply(result, rest) | {"date": record.date, "stance": stance}
        if self._offsets.error:
            answer["message"] += f"; {self._offsets.error}"
        return answer


def _reply(result: TareResult, rest: RestingMean) -> dict[str, Any]:
    return {
        "tared": list(result.tared),
        "relative": [list(group) for group in result.relative],
        "unobservable": list(result.unobservable),
        "offset": result.offset.tolist(),
        "spread": rest.spread.tolist(),
        "samples": rest.samples,
        "message": result.message,
    }
