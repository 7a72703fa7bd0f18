"""Scenarios: what happens to the robot while nobody asks for anything."""

from importlib.resources import files
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from robot_model import Robot
from robot_model.names import did_you_mean
from robot_sim.motions import Motion, Sinusoid
from robot_sim.plant import TICK, Plant
from robot_sim.pushes import Profile

SCENARIOS = files("robot_sim") / "scenarios"

Vector3 = Annotated[list[float], Field(min_length=3, max_length=3)]
Range = Annotated[list[float], Field(min_length=2, max_length=2)]


class Strict(BaseModel):
    """Refuses unknown keys; never changes after loading."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Spot(Strict):
    """A place on the robot where somebody may push, in the link's frame."""

    link: str
    point: Vector3  # m
    direction: Vector3  # into the body, any length but zero


class Touches(Strict):
    """Pushes on one spot after the other, drawn by the seed."""

    first: float = Field(default=5.0, ge=0)  # s until the first
    every: Range = [5.0, 9.0]  # s from one start to the next, at least and at most
    force: Range = [8.0, 15.0]  # N
    duration: Range = [1.5, 2.5]  # s
    profile: Profile = "half_sine"
    spots: list[Spot] = Field(min_length=1)


class PlannedPush(Strict):
    """One push at a fixed time; see ``Plant.push``."""

    at: float = Field(ge=0)  # s
    link: str
    point: Vector3  # m, link frame
    force: Vector3  # N
    frame: Literal["link", "world"] = "link"
    profile: Profile = "hold"
    duration: float | None = Field(default=None, gt=0)  # s


class Scenario(Strict):
    """Pushes and motions; see ``robot_sim/scenarios``."""

    description: str = ""
    touches: Touches | None = None
    pushes: list[PlannedPush] = []
    motions: dict[str, dict[str, Sinusoid]] = {}
    start_motion: str | None = None

    def motion(self, name: str) -> Motion:
        """Return a motion by name, or raise LookupError that says which exist."""
        if name not in self.motions:
            hint = did_you_mean(name, self.motions)
            raise LookupError(f"the scenario has no motion {name!r}{hint}")
        return Motion(name, self.motions[name])

    def check(self, robot: Robot) -> None:
        """Raise LookupError when a link, joint or motion does not exist."""
        spots = self.touches.spots if self.touches else []
        for place in (*spots, *self.pushes):
            robot.require_link(place.link)
        for name in self.motions:
            self.motion(name).checked(robot)
        if self.start_motion is not None:
            self.motion(self.start_motion)


def load_scenario(name: str | Path, robot: Robot) -> Scenario:
    """Read a packaged scenario by name, or a file by path, and check it against the robot.

    Raises:
        LookupError: no such scenario, or it names a link or joint that does not exist.
        ValueError: the file is not a scenario; the text names the key.
    """
    known = sorted(entry.name[:-5] for entry in SCENARIOS.iterdir() if entry.name.endswith(".yaml"))
    source = SCENARIOS / f"{name}.yaml" if name in known else Path(name)
    if not source.is_file():
        raise LookupError(f"scenario {str(name)!r} not found{did_you_mean(str(name), known)}")
    try:
        scenario = Scenario.model_validate(yaml.safe_load(source.read_text()) or {})
        scenario.check(robot)
    except yaml.YAMLError as error:
        raise ValueError(f"scenario {source}: {' '.join(str(error).split())}") from None
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        raise ValueError(f"scenario {source}: {key}: {first['msg']}") from None
    except LookupError as error:
        raise LookupError(f"scenario {source}: {error.args[0]}") from None
    return scenario


class ScenarioPlayer:
    """Plays a scenario on a plant; call ``step`` before every step of the plant."""

    def __init__(self, plant: Plant, scenario: Scenario, seed: int = 0):
        self.scenario = scenario
        self._plant = plant
        self._seed = seed
        self.restart()

    def restart(self) -> None:
        """Begin again, now; call it after every reset of the plant."""
        self._begin = self._plant.time
        self._random = np.random.default_rng(self._seed)
        self._planned = sorted(self.scenario.pushes, key=lambda push: push.at)
        touches = self.scenario.touches
        self._next_touch = np.inf if touches is None else touches.first
        if self.scenario.start_motion is not None:
            self._plant.motion(self.scenario.motion(self.scenario.start_motion))

    def step(self) -> None:
        """Start what is due with the plant's next step."""
        time = (self._plant.time + TICK - self._begin) * 1e-9
        while self._planned and self._planned[0].at <= time:
            due = self._planned.pop(0)
            self._plant.push(**due.model_dump(exclude={"at"}))
        if time >= self._next_touch and self.scenario.touches is not None:
            self._touch(self.scenario.touches)

    def _touch(self, touches: Touches) -> None:
        spot = touches.spots[self._random.integers(len(touches.spots))]
        direction = np.array(spot.direction) / np.linalg.norm(spot.direction)
        force = self._draw(touches.force) * direction
        duration = self._draw(touches.duration)
        self._next_touch += self._draw(touches.every)
        if not self._plant.fallen:
            self._plant.push(
                spot.link, np.array(spot.point), force, "link", touches.profile, duration
            )

    def _draw(self, span: list[float]) -> float:
        return float(self._random.uniform(span[0], span[1]))
