"""Do the stated intervals hold the truth as often as they say?

Each run draws sensor biases, masses and centres of mass anew, moves the robot on its pole
between random postures and pushes a limb at a point that the observer is told. The observer
knows how large the errors are, not what they are; nothing is tared.
"""

from collections.abc import Iterator
from dataclasses import asdict
from typing import NamedTuple

import numpy as np

from estimation.differentiation import Kernel
from estimation.observer_covariance import ObserverNoise, Uncertainty, propagate
from estimation.sensor_pipeline import SensorPipeline
from estimation.torque_observer import Estimate, TorqueObserver
from experiments.limb_motion import LimbMotion
from experiments.pole_run import stiff
from experiments.report import Report, markdown_table
from experiments.wrong_bodies import wrong_bodies
from robot_model import Robot
from robot_model.messages import GroundTruth, SensorFrame
from robot_sim import Plant
from robot_sim.noise import NoiseProfile, load_profile

Array = np.ndarray
NAME, PROFILE = "coverage", "realistic"
MASS, CENTER = 0.02, 0.002  # standard deviations: share of a body's mass, m
BEGIN, END, EVERY = 400, 1200, 20  # ticks of 1 ms: first and last sample, and from one to the next
FORCE = 10.0  # N, standard deviation of each axis of the push
WINDOW = Kernel(period=1e-3, delay=0.024)  # s, the sensor pipeline's own
CUT = 0.9594  # deviation of a normal variable that is cut at two of its own, as biases are
INTERVALS = {"50 %": 0.67449, "68 %": 0.99446, "95 %": 1.95996, "99 %": 2.57583}  # in deviations


class Errors(NamedTuple):
    """Errors in stated standard deviations, by quantity; any shape."""

    torque: Array
    force: Array
    moment: Array


def run(robot: Robot, seed: int = 1, runs: int = 200) -> Report:
    """Count how often intervals hold the truth.

    Args:
        robot: A robot with a ``pole`` support and force/torque sensors.
        seed: Of the first run.
        runs: How many draws of all errors.

    Raises:
        ValueError: There is no run.
    """
    if runs < 1:
        raise ValueError(f"an experiment needs at least 1 run, got {runs}")
    samples = [errors for i in range(runs) for errors in _run(robot, seed + i)]
    pooled = {
        name: np.concatenate([np.ravel(getattr(errors, name)) for errors in samples])
        for name in Errors._fields
    }
    pooled["all"] = np.concatenate(list(pooled.values()))
    held = {
        name: {text: float((np.abs(z) < bound).mean()) for text, bound in INTERVALS.items()}
        for name, z in pooled.items()
    }
    about = {"robot": robot.name, "seed": seed, "runs": runs, "samples": len(samples)}
    noise = asdict(noise_of(load_profile(PROFILE), WINDOW))
    table = _table(held)
    return Report(
        name=NAME,
        figures=about | {"noise": noise, "held": held},
        lines=[f"how often an interval holds the truth, {runs} runs", *table.splitlines()],
        files={f"{NAME}.md": f"# Coverage of the stated intervals\n\n{table}"},
    )


def noise_of(profile: NoiseProfile, kernel: Kernel) -> ObserverNoise:
    """Return the standard deviations that a noise profile leaves in filtered channels."""
    value, slope, curvature = kernel.noise_gain.tolist()
    bits = profile.encoder_bits or 0
    count = 2.0 * np.pi / 2**bits / np.sqrt(12.0) if bits else 0.0  # rad, of a rounded position

    def combined(white: float, bias: float) -> float:
        return float(np.hypot(value * white, CUT * bias / 2))

    return ObserverNoise(
        force=combined(profile.ft_force.white, profile.ft_force.bias),
        moment=combined(profile.ft_moment.white, profile.ft_moment.bias),
        acceleration=combined(profile.accelerometer.white, profile.accelerometer.bias),
        angular_acceleration=slope * profile.gyro.white,
        angular_velocity=combined(profile.gyro.white, profile.gyro.bias),
        joint_velocity=slope * count,
        joint_acceleration=curvature * count,
        mass=MASS,
        center_of_mass=CENTER,
    )


def _run(robot: Robot, seed: int) -> Iterator[Errors]:
    """Yield the errors of one run's samples."""
    random = np.random.default_rng(seed)
    link, point, force = _push(robot, random)
    plant = Plant(stiff(robot), "fixed", PROFILE, seed)
    believed = wrong_bodies(robot, random, MASS, CENTER)
    observer = TorqueObserver(believed, "pole")
    observer.set_contacts([(link, point)])
    expected = _expected(observer, force)
    noise = noise_of(load_profile(PROFILE), WINDOW)
    for truth, frame in _samples(plant, LimbMotion(robot, seed, 1), (link, point, force)):
        inertial = frame.imu_gyro[0], frame.imu_acc[0], frame.imu_dgyro[0]
        motion = frame.q, frame.dq, frame.ddq, *inertial
        estimate = observer.step(*motion[:3], frame.ft, *inertial)
        expected[0] = truth.support_wrench[0]
        yield _errors(estimate, propagate(observer, noise, *motion), truth, expected)


def _push(robot: Robot, random: np.random.Generator) -> tuple[str, Array, Array]:
    """Return the link at which a random limb is pushed, the point in it, and the force."""
    subtree = robot.subtrees[random.integers(1, len(robot.subtrees))]
    link = robot.frame(subtree.default_frame)[0]
    return link, 0.03 * random.normal(size=3), FORCE * random.normal(size=3)


def _expected(observer: TorqueObserver, force: Array) -> Array:
    """True wrenches (c, 6) but for the support's, which comes first."""
    expected = np.zeros((len(observer.contacts), 6))
    touched = [contact.kind == "touch" for contact in observer.contacts]
    expected[touched, :3] = force
    return expected


def _samples(
    plant: Plant, motion: LimbMotion, push: tuple[str, Array, Array]
) -> Iterator[tuple[GroundTruth, SensorFrame]]:
    """Yield what is true, and what the filtered sensors say, of the same instants."""
    pipeline, truths = SensorPipeline(plant.robot), {}
    plant.push(*push)
    for tick in range(END):
        plant.command(motion.position(tick * 1e-3))
        plant.step()
        frame = pipeline.step(plant.raw(), plant.time)
        instant = plant.time - round(frame.delay * 1e9)
        if tick >= BEGIN and (tick - BEGIN) % EVERY == 0:
            truths[plant.time] = plant.truth()
        if instant in truths:
            yield truths[instant], frame


def _errors(
    estimate: Estimate, uncertainty: Uncertainty, truth: GroundTruth, expected: Array
) -> Errors:
    std = np.sqrt(np.diagonal(uncertainty.wrench, axis1=1, axis2=2))
    wrench = (estimate.wrench - expected) / std
    torque = (estimate.torque - truth.link_torque) / uncertainty.torque_std
    return Errors(torque, wrench[:, :3], wrench[:, 3:])


def _table(held: dict[str, dict[str, float]]) -> str:
    rows = [[name, *(f"{100 * share:.1f} %" for share in of.values())] for name, of in held.items()]
    return markdown_table(["quantity", *INTERVALS], rows)
