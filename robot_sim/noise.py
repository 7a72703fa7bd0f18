"""Sensor noise: a profile says how wrong the sensors are, a seed says which wrong it is."""

from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

import numpy as np
import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from robot_model.inertial import InertialSensor
from robot_model.names import did_you_mean

PROFILES = files("robot_sim") / "profiles"
BLOCK = 64  # ticks drawn at once; takes as long as a fraction of a tick


class Channel(BaseModel):
    """Error of one kind of sensor, in the channel's unit."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    white: float = Field(default=0.0, ge=0.0)  # standard deviation per sample at 1 kHz
    bias: float = Field(default=0.0, ge=0.0)  # bound of the constant error of a run


class NoiseProfile(BaseModel):
    """How wrong the sensors are; see ``robot_sim/profiles``."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    description: str = ""
    encoder_bits: int | None = Field(default=None, ge=8, le=32)  # counts per turn, None: exact
    derivatives: bool = False  # boards deliver joint velocity and acceleration, the IMU dgyro
    ft_force: Channel = Channel()  # N
    ft_moment: Channel = Channel()  # N m
    motor_torque: Channel = Channel()  # N m
    gyro: Channel = Channel()  # rad/s
    accelerometer: Channel = Channel()  # m/s^2
    orientation: Channel = Channel()  # rad, rotation vector
    coulomb: float = Field(default=0.0, ge=0.0)  # factor on the description's Coulomb friction


def load_profile(name: str | Path) -> NoiseProfile:
    """Read a packaged profile by name, or a profile file by path.

    Raises:
        LookupError: no such profile; the text lists those that exist.
        ValueError: the file is not a profile; the text names the key.
    """
    known = sorted(entry.name[:-5] for entry in PROFILES.iterdir() if entry.name.endswith(".yaml"))
    source = PROFILES / f"{name}.yaml" if name in known else Path(name)
    if not source.is_file():
        raise LookupError(f"noise profile {str(name)!r} not found{did_you_mean(str(name), known)}")
    try:
        return NoiseProfile.model_validate(yaml.safe_load(source.read_text()) or {})
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        raise ValueError(f"noise profile {source}: {key}: {first['msg']}") from None


class Noise:
    """Errors of all sensors of one run, drawn tick by tick.

    One normal vector per tick serves every channel, and the vectors of some ticks are
    drawn at once, so that the generator need not be called at every tick. Biases are
    normal with half the bound as standard deviation, cut at the bound.

    Args:
        profile: Size of the errors.
        n, k, m: Number of joints, force/torque sensors and inertial sensors.
        inertial: The inertial sensors (m of them), where they differ.
        seed: The same seed gives the same errors, sample by sample.

    Attributes:
        errors: Present error by channel, in its shape and unit; changed by ``draw``.
    """

    def __init__(
        self,
        profile: NoiseProfile,
        n: int,
        k: int,
        m: int,
        seed: int,
        inertial: Sequence[InertialSensor] = (),
    ):
        self.profile = profile
        self.seed = seed
        ft = (profile.ft_force, profile.ft_moment)
        channels = {
            "ft": [channel for channel in ft for _ in range(3)] * k,
            "motor_torque": [profile.motor_torque] * n,
            "gyro": [profile.gyro] * 3 * m,
            "accelerometer": [profile.accelerometer] * 3 * m,
            "orientation": [profile.orientation] * 3 * m,
        }
        shapes = {"ft": (k, 6), "motor_torque": (n,)}
        self._white = np.array([c.white for values in channels.values() for c in values])
        self._bound = np.array([c.bias for values in channels.values() for c in values])
        self._error = np.zeros(self._white.size)
        self._drawn = np.zeros((BLOCK, self._white.size))
        if inertial:
            factor = np.concatenate([np.ones(6 * k + n), *_inertial_factors(inertial)])
            self._white, self._bound = self._white * factor, self._bound * factor
        ends = np.cumsum([len(values) for values in channels.values()])
        self.errors = {
            name: piece.reshape(shapes.get(name, (m, 3)))
            for name, piece in zip(channels, np.split(self._error, ends[:-1]), strict=True)
        }
        self._count = None
        if profile.encoder_bits is not None:
            self._count = 2 * np.pi / 2**profile.encoder_bits  # rad
            self._counts_per_radian = 1.0 / self._count
        self.restart()

    def restart(self) -> None:
        """Go back to the first sample of the run: same seed, same biases, same errors."""
        self._random = np.random.default_rng(self.seed)
        bias = self._random.standard_normal(self._bound.size) * self._bound / 2
        self.bias = np.clip(bias, -self._bound, self._bound)
        self._next = BLOCK
        self.draw()

    def draw(self) -> None:
        """Draw the errors of the next sample."""
        if self._next == BLOCK:
            self._random.standard_normal(out=self._drawn)
            self._drawn *= self._white
            self._drawn += self.bias
            self._next = 0
        self._error[:] = self._drawn[self._next]
        self._next += 1

    def encoder(self, q: np.ndarray) -> np.ndarray:
        """Return positions (n,) [rad] as the encoders count them."""
        if self._count is None:
            return q.copy()
        counts = q * self._counts_per_radian
        np.rint(counts, out=counts)
        counts *= self._count
        return counts


def _inertial_factors(sensors: Sequence[InertialSensor]) -> list[np.ndarray]:
    """Return factors on the errors of gyros, accelerometers and orientations, (3 m,) each."""
    measured = [[s.gyro, s.accelerometer, s.complete] for s in sensors]
    factors = np.array([s.noise for s in sensors])[:, None] * measured
    return [column.repeat(3) for column in factors.T]
