"""Runs in lockstep, recorded: of the plant, and of a recording in its place."""

import platform
from importlib.metadata import version
from pathlib import Path

from bus import Node
from bus.introspection import hear_all, port_infos
from bus.recording import Recording, RecordingWriter
from bus.recording.player import RPC
from bus.recording.recorder import Recorder
from robot_model import Robot, ports
from tests.system.stack import MODULES, STREAMS, Stack

REFERENCE = Path(__file__).parents[1] / "data" / "replay.mcap"
PARTICIPANTS = [name for name in MODULES if name not in ("robot_sim", "dashboard")]
CHUNK = 20  # ticks of one request, each answered in time on the slowest machine
PUSHED = 240  # ticks until the push
PUSH = {"link": "l_forearm", "force": [0.0, 0.0, -25.0], "frame": "world"}


def outputs(robot: Robot) -> list[str]:
    """Return the ports whose estimates are compared."""
    return [ports.name(key, robot) for key in STREAMS]


def machine() -> dict[str, str]:
    """Return what the last bits of a sum depend on."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    model = next((line.split(": ")[1] for line in lines if line.startswith("model name")), "")
    packages = {name: version(name) for name in ("numpy", "pin", "scipy")}
    return {"cpu": model, "system": platform.platform(terse=True), **packages}


def record_live(robot: Robot, path: Path, ticks: int, truth: bool = True) -> Recording:
    """Record a robot that is measured as a real one would be, and pushed; from its first tick.

    The feed-forward is cut: whether it reaches the plant one tick earlier or later is
    chance, and equal arguments shall give equal recordings.
    """
    plant = ["--set", f"participants={_listed(PARTICIPANTS)}", "--set", "paused=true"]
    plant += ["--set", "profile=realistic", "--set", f"truth={str(truth).lower()}"]
    server = ["--set", "inputs={feedforward: /icub/nothing:o}"]
    settings = _settings({"robot_sim": plant, "sensor_server": server})
    names = [*outputs(robot), ports.name("raw", robot)]
    names += [ports.name("truth", robot)] if truth else []
    with Stack(robot, settings, without=["dashboard"]) as stack:
        with _Capture(stack, path, names) as recorder:
            for tick in range(0, ticks, CHUNK):
                if tick == PUSHED:
                    stack.simulate("push", **PUSH)
                stack.simulate("step", ticks=CHUNK)
                recorder.step()
    return Recording(path)


def record_replay(robot: Robot, file: Path, path: Path) -> Recording:
    """Record what the services make of a recording's raw frames."""
    replay = ["--set", "driver=replay", "--set", f"replay.file={file}"]
    replay += ["--set", f"replay.participants={_listed(PARTICIPANTS)}"]
    settings = _settings({"sensor_server": [*replay, "--set", "replay.paused=true"]})
    with Stack(robot, settings, without=["dashboard", "robot_sim"]) as stack:
        with _Capture(stack, path, outputs(robot)) as recorder:
            stack.node.call(RPC, "resume")

            def over() -> bool:
                recorder.step()
                return stack.node.call(RPC, "status", timeout=10.0)["ended"]

            stack.until(over, lambda: str(stack.node.call(RPC, "status")))
    return Recording(path)


def _settings(more: dict[str, list[str]]) -> dict[str, list[str]]:
    lockstep = ["--set", "lockstep=true"]
    found = {name: list(lockstep) for name in ("robot_sim", *PARTICIPANTS)}
    # tared soon, though the robot still settles
    found["contact_detector"] += ["--set", "tare={window: 0.12, patience: 0.0}"]
    return {name: arguments + more.get(name, []) for name, arguments in found.items()}


def _listed(names: list[str]) -> str:
    return f"[{', '.join(names)}]"


class _Capture:
    """A recorder on some ports of a stack."""

    def __init__(self, stack: Stack, path: Path, names: list[str]):
        self._stack, self._path, self._names = stack, path, names

    def __enter__(self) -> Recorder:
        self._node = Node("recorder", connect=self._stack.endpoint, signals=False)
        self._node.ready()
        hear_all(self._node, lambda: set(self._names) <= set(self._node.directory.names()))
        self._recorder = Recorder(self._node, RecordingWriter(self._path, machine()), self._names)
        self._stack.until(self._is_heard, lambda: "the recorder is not heard")
        return self._recorder

    def _is_heard(self) -> bool:
        """Whether every writer knows that it is read, so that it writes from the first tick."""
        self._recorder.step()
        return all(info.get("wanted_hz") for info in port_infos(self._node, self._names))

    def __exit__(self, *_: object) -> None:
        try:
            self._recorder.close()
        finally:
            self._node.close()
