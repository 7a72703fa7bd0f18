"""A standing robot that is recorded, and what a contact detector says of it."""

from collections.abc import Iterator

import numpy as np

from estimation.contact.contact_detector import ContactDetector, DetectorSettings
from estimation.contact.quiet_period import QuietPeriod
from estimation.sensor_pipeline import SensorPipeline
from robot_model import Robot
from robot_model.messages import SensorFrame
from robot_sim import Plant
from robot_sim.motions import Sinusoid

EVERY = 4  # ticks of 1 ms between frames
Frames = list[tuple[int, SensorFrame]]  # stamp [ns], frame
SWAY = {  # shifts 100 N from foot to foot, and turns torso, neck and arms
    "l_hip_roll": Sinusoid(amplitude=0.03, frequency=0.5),
    "l_ankle_roll": Sinusoid(amplitude=0.03, frequency=0.5),
    "r_hip_roll": Sinusoid(amplitude=0.03, frequency=0.5, phase=np.pi),
    "r_ankle_roll": Sinusoid(amplitude=0.03, frequency=0.5, phase=np.pi),
    "torso_yaw": Sinusoid(amplitude=0.1, frequency=0.4),
    "neck_yaw": Sinusoid(amplitude=0.25, frequency=0.6),
    "l_elbow": Sinusoid(amplitude=0.25, frequency=0.5),
    "r_shoulder_pitch": Sinusoid(amplitude=0.25, frequency=0.7),
}
PUSH = {"link": "r_upper_leg", "force": [0.0, -15.0, 0.0]}


class Recorder:
    """A standing plant with exact sensors."""

    def __init__(self, robot: Robot, profile: str = "ideal"):
        self.plant, self._pipeline = Plant(robot, profile=profile), SensorPipeline(robot)
        self._record(2000)

    def record(self, seconds: float) -> Frames:
        return list(self._record(round(seconds * 1000)))

    def _record(self, ticks: int) -> Frames:
        frames = []
        for tick in range(ticks):
            self.plant.step()
            if tick % EVERY == EVERY - 1:
                frames.append(
                    (self.plant.time, self._pipeline.step(self.plant.raw(), self.plant.time))
                )
        return frames


def tared(robot: Robot, rest: Frames, settings: DetectorSettings | None = None) -> ContactDetector:
    detector = ContactDetector(robot, settings=settings)
    quiet = QuietPeriod(robot.joints)
    for stamp, frame in rest:
        detector.step(frame, stamp)
        add(quiet, detector, frame)
    detector.tare(quiet.finish())
    return detector


def add(period: QuietPeriod, detector: ContactDetector, frame: SensorFrame) -> None:
    rows = detector.untared_rows
    wrenches = detector.rows.wrenches(rows)
    period.add(frame, rows, detector.rows.predicted, wrenches, np.zeros(0), detector.tared_rows)


def alarms(detector: ContactDetector, frames: Frames) -> Iterator[set[str]]:
    """Yield the names of the flags that are raised, frame by frame."""
    for stamp, frame in frames:
        flags = [*detector.step(frame, stamp), detector.body]
        yield {flag.limb for flag in flags if flag.state != "none"}


def watch(detector: ContactDetector, frames: Frames) -> set[str]:
    """Return the names of all flags that are raised."""
    return set().union(*alarms(detector, frames))
