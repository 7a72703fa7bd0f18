"""Logs of the simulated robot as ``wrenchbus estimate`` reads them, with the truth."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from deploy.main import run
from robot_model import Robot
from robot_model.messages import GroundTruth
from robot_sim import Plant
from robot_sim.motions import Motion, Sinusoid

PUSHED = 100  # tick of the push
LINK, POINT = "l_forearm", np.array([0.050, -0.010, -0.034])  # on its surface
FORCE = 12.0 * np.array([-0.33, 0.10, 0.94])  # N, inwards
SWING = {
    "l_elbow": Sinusoid(amplitude=0.4, frequency=1.5),
    "neck_yaw": Sinusoid(amplitude=0.3, frequency=1.0),
}
EXACT = ("dq", "ddq", "imu_dgyro")


class Simulated(NamedTuple):
    """Arrays of a log by name, and the truth of every sample."""

    arrays: dict[str, np.ndarray]
    truth: list[GroundTruth]

    def true(self, name: str) -> np.ndarray:
        """Return a field of the truth, stacked."""
        return np.array([getattr(each, name) for each in self.truth])


def simulate(robot: Robot, base: str, ticks: int, profile: str = "ideal") -> Simulated:
    """Let the robot swing an arm and its head, and push its forearm from 0.1 s on."""
    plant = Plant(robot, base, profile)  # type: ignore[arg-type]
    plant.motion(Motion("swing", SWING))
    frames, truth = [], []
    for tick in range(ticks):
        if tick == PUSHED:
            plant.push(LINK, POINT, FORCE)
        plant.step()
        frames.append((plant.time, plant.raw()))
        truth.append(plant.truth())
    raw = {
        name: np.array([getattr(frame, name) for _, frame in frames])
        for name in ("q", "motor_torque", "ft", "imu_gyro", "imu_acc", *EXACT)
        if getattr(frames[0][1], name) is not None
    }
    arrays = {"stamp": np.array([stamp for stamp, _ in frames])}
    arrays |= {f"ft_{sensor}": raw["ft"][:, i] for i, sensor in enumerate(robot.ft_sensors)}
    for name, values in raw.items():
        if name != "ft":
            arrays[name] = values[:, 0] if name.startswith("imu") else values
    return Simulated(arrays, truth)


def without(arrays: dict[str, np.ndarray], *names: str) -> dict[str, np.ndarray]:
    """Return the other arrays."""
    return {name: array for name, array in arrays.items() if name not in names}


def estimated(
    arrays: dict[str, np.ndarray], folder: Path, *arguments: str
) -> dict[str, np.ndarray]:
    """Run the command on some arrays and return what it wrote."""
    source, out = folder / "log.npz", folder / "out.npz"
    np.savez(source, allow_pickle=False, **arrays)
    assert run(["estimate", "--robot", "icub", str(source), "-o", str(out), *arguments]) == 0
    with np.load(out, allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}
