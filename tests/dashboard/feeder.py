"""A process that publishes plausible messages of all services, so that the page can be tried alone.

It sways the robot of its settings; a push that it is asked for becomes a contact
message after a while, as the detector's would. ``python -m tests.dashboard.feeder``
"""

import sys
import time
from typing import Any

import numpy as np

from bus import Node
from bus.clock import ClockServer
from bus.service import serve
from robot_model import Robot, load_robot, ports
from robot_model.messages import (
    BaseState,
    ContactMap,
    Contacts,
    ExternalWrenches,
    GroundTruth,
    JointTorques,
    Residuals,
    SensorFrame,
)
from robot_model.service_config import RobotServiceConfig

MESSAGES = {
    "sensors": SensorFrame,
    "base": BaseState,
    "torques": JointTorques,
    "wrenches": ExternalWrenches,
    "residuals": Residuals,
    "contacts": Contacts,
    "contact_map": ContactMap,
    "truth": GroundTruth,
}
STEP = 0.02  # [s]


class FeederConfig(RobotServiceConfig):
    mute: list[str] = []  # messages left out
    repeat: int = 1  # copies of each message per step


class Feeder:
    @classmethod
    def silent(cls, robot: Robot, config: FeederConfig) -> "Feeder":
        """Return one that is on no bus."""
        feeder = cls.__new__(cls)
        feeder.robot, feeder.config = robot, config
        feeder.push, feeder.time = None, 0.0
        feeder.surface = robot.load_surface()
        return feeder

    def __init__(self, node: Node, robot: Robot, config: FeederConfig):
        self.robot, self.node, self.config = robot, node, config
        self.surface = robot.load_surface()
        self.outputs = {
            what: node.output(
                ports.name(what, robot),
                message,
                rate=50.0,
                model=robot.model_hash,
                dimensions=robot.dimensions,
            )
            for what, message in MESSAGES.items()
            if what not in config.mute
        }
        self.clock = ClockServer(node, ports.name("clock", robot), ports.rate("clock"))
        self.push: dict[str, Any] | None = None
        self.until = 0.0
        self.time, self.paused, self.holding = 0.0, False, False
        self.recording = False
        self.settings: dict[str, float] = {"levels.contact": 6.5}
        self._serve()

    def _serve(self) -> None:
        sim = {"push": self._push, "pause": self._pause, "resume": self._resume}
        self.node.rpc(ports.sim_rpc(self.robot), sim)
        observer = {"tare": self._tare, "status": self._offsets}
        self.node.rpc(ports.rpc("torque_observer"), observer)
        detector = {"tare": self._refuse, "param": self._param}
        self.node.rpc(ports.rpc("contact_detector"), detector)
        stops = {"stop": self._stop, "release": self._release, "status": self._status}
        self.node.rpc(ports.rpc("sensor_server"), stops)
        record = {"start": self._record, "stop": self._finish, "status": self._recorded}
        self.node.rpc(ports.rpc("recorder"), record)

    def _push(self, **push: Any) -> dict[str, Any]:
        self.push, self.until = push, self.time + push["duration"]
        return {"push_id": 1, "start_stamp": int(self.time * 1e9)}

    def _pause(self) -> str:
        self.paused = True
        return "paused"

    def _resume(self) -> str:
        self.paused = False
        return "running"

    def _record(self) -> dict[str, Any]:
        self.recording = True
        return self._recorded()

    def _finish(self) -> dict[str, Any]:
        self.recording = False
        return self._recorded()

    def _recorded(self) -> dict[str, Any]:
        told = {"file": "/data/walk.mcap", "size": 12_300_000, "seconds": 94.0, "lost": 0}
        return {**told, "recording": self.recording, "warning": "", "error": ""}

    def _tare(self, seconds: float = 1.0) -> dict[str, Any]:
        return {"tared": ["l_arm_ft"], "unobservable": [], "message": f"tared in {seconds:g} s"}

    def _offsets(self) -> dict[str, Any]:
        offset = {"l_arm_ft": [1.25, -0.5, 2.0, 0.01, 0.02, 0.03]}
        tare = {"date": "2026-01-01", "stance": "pole", "samples": 1000, "error": ""}
        return {"offset": offset, "tare": tare | {"spread": {"l_arm_ft": [0.25] * 6}}}

    def _refuse(self, seconds: float = 1.0) -> dict[str, Any]:
        raise RuntimeError("tare refused: the robot moves, l_elbow at 0.30 rad/s")

    def _param(self, action: str, name: str = "", value: float = 0.0) -> Any:
        if action == "list":
            return dict(self.settings)
        if action == "save":
            return {"file": "/state/x.yaml", "message": "saved in /state/x.yaml"}
        self.settings[name] = value if action == "set" else 6.5
        return self.settings[name]

    def _stop(self) -> str:
        self.holding = True
        return "holding"

    def _release(self) -> str:
        self.holding = False
        return "released"

    def _status(self) -> dict[str, Any]:
        return {"holding": self.holding}

    def step(self) -> None:
        self.clock.update(int(self.time * 1e9), "paused" if self.paused else "running")
        if self.paused:
            return
        self.time += STEP
        if self.time > self.until:
            self.push = None
        stamp = int(self.time * 1e9)
        for what, output in self.outputs.items():
            message = getattr(self, what)()
            for _ in range(self.config.repeat):
                output.write(message, stamp=stamp, clock=1)

    def posture(self) -> np.ndarray:
        sway = 0.03 * np.sin(1.5 * self.time + np.arange(self.robot.n))
        return self.robot.home + sway

    def sensors(self) -> SensorFrame:
        n, k, m = (self.robot.dimensions[letter] for letter in "nkm")
        return SensorFrame(
            q=self.posture(),
            dq=np.zeros(n),
            ddq=np.zeros(n),
            motor_torque=np.zeros(n),
            ft=np.zeros((k, 6)),
            imu_gyro=np.zeros((m, 3)),
            imu_acc=np.zeros((m, 3)),
            imu_dgyro=np.zeros((m, 3)),
            joint_valid=np.ones(n, dtype=bool),
            ft_valid=np.ones(k, dtype=bool),
            imu_valid=np.ones(m, dtype=bool),
        )

    def base(self) -> BaseState:
        return BaseState(
            position=np.array([0.0, 0.01 * np.sin(self.time), 0.6]),
            quat_wxyz=np.array([1.0, 0.0, 0.0, 0.0]),
            twist=np.zeros(6),
            covariance=np.eye(12),
        )

    def torques(self) -> JointTorques:
        n = self.robot.n
        torque = 5.0 * np.sin(self.time + np.arange(n))
        return JointTorques(torque=torque, std=np.ones(n), valid=np.ones(n, dtype=bool))

    def wrenches(self) -> ExternalWrenches:
        frames = [*self.robot.supports["floor"], *(t.default_frame for t in self.robot.subtrees)]
        count, soles = len(frames), len(self.robot.supports["floor"])
        wrench = np.zeros((count, 6))
        wrench[:soles, 2] = 150.0
        return ExternalWrenches(
            frame=frames,
            link=[self.robot.frame(frame)[0] for frame in frames],
            subtree=[""] * count,
            point=np.array([self.robot.frame(frame)[1].translation for frame in frames]),
            wrench=wrench,
            covariance=np.zeros((count, 6, 6)),
            valid=np.ones(count, dtype=bool),
            kind=["support"] * soles + ["default"] * (count - soles),
            subtree_wrench=np.zeros((len(self.robot.subtrees), 6)),
            subtree_valid=np.ones(len(self.robot.subtrees), dtype=bool),
        )

    def residuals(self) -> Residuals:
        n = self.robot.n
        return Residuals(
            internal=np.sin(3.0 * self.time + np.arange(n)),
            external=np.zeros(6),
            threshold_internal=np.full(n, 2.0),
            threshold_external=np.full(6, 5.0),
        )

    def contacts(self) -> Contacts:
        limbs = [subtree.name for subtree in self.robot.subtrees]
        quiet = {"state": "none", "probability": 0.01, "onset": 0, "force": 0.0}
        quiet |= {"statistic": 1.5, "threshold": 6.5}
        flags = [{"limb": limb, **quiet} for limb in limbs]
        if self.push is None:
            return Contacts(flags=flags, hypotheses=[], none_probability=0.99, body=quiet)
        touched = {"state": "contact", "probability": 0.9, "statistic": 12.0}
        flags[self.robot.subtree_of(self.push["link"])] |= touched
        return Contacts(
            flags=flags,
            hypotheses=[self._hypothesis()],
            none_probability=0.1,
            body=quiet | touched,
        )

    def contact_map(self) -> ContactMap:
        push = self.push
        if push is None:
            nothing = np.zeros((0, 3))
            return ContactMap(
                link=[],
                count=[],
                point=nothing,
                probability=np.zeros(0),
                limb=[],
                line_point=nothing,
                line_direction=nothing,
            )
        body = [body.name for body in self.surface.bodies].index(push["link"])
        points = self.surface.points[self.surface.body == body]
        distance = np.linalg.norm(points - np.array(push["point"]), axis=1)
        likelihood = np.exp(-0.5 * (distance / 0.02) ** 2)
        direction = np.array(push["force"]) / np.linalg.norm(push["force"])
        return ContactMap(
            link=[push["link"]],
            count=[len(points)],
            point=points,
            probability=likelihood / likelihood.sum(),
            limb=[self.robot.subtrees[self.robot.subtree_of(push["link"])].name],
            line_point=np.array([[0.0, 0.2, 0.1]]),
            line_direction=direction[None],
        )

    def _hypothesis(self) -> dict[str, Any]:
        push = self.push or {}
        return {
            "links": [push["link"]],
            "point": push["point"],
            "force": push["force"],
            "covariance": np.eye(6).tolist(),
            "probability": 0.9,
        }

    def truth(self) -> GroundTruth:
        n, k = self.robot.n, len(self.robot.ft_sensors)
        push = self.push
        pushes = (
            []
            if push is None
            else [
                {
                    "id": 1,
                    "link": push["link"],
                    "point": push["point"],
                    "force_world": push["force"],
                }
            ]
        )
        soles = list(self.robot.supports["floor"])
        wrench = np.zeros((len(soles), 6))
        wrench[:, 2] = 150.0
        return GroundTruth(
            q=self.posture(),
            dq=np.zeros(n),
            ddq=np.zeros(n),
            link_torque=np.zeros(n),
            motor_torque=np.zeros(n),
            ft=np.zeros((k, 6)),
            base_position=np.array([0.0, 0.0, 0.6]),
            base_quat_wxyz=np.array([1.0, 0.0, 0.0, 0.0]),
            base_twist=np.zeros(6),
            base_acceleration=np.zeros(6),
            pushes=pushes,
            support_frames=soles,
            support_wrench=wrench,
        )


def main(node: Node, config: FeederConfig) -> None:
    feeder = Feeder(node, load_robot(config.robot), config)
    node.ready()
    due = time.monotonic()
    while node.running:
        feeder.step()
        due += STEP
        while (remaining := due - time.monotonic()) > 0.0:
            node.wait(remaining)


if __name__ == "__main__":
    sys.exit(serve(main, FeederConfig, "feeder"))
