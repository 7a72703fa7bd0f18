"""Sensor noise: a profile says how wrong the sensors are, a seed says which wrong it is."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np
import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from robot_model.names import did_you_mean

PROFILES = files("robot_sim") / "profiles"


class Channel(BaseModel):
    """Error of one kind of sensor, in the channel's unit."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    white: float = Field(0.0, ge=0.0)  # standard deviation per sample at 1 kHz
    bias: float = Field(0.0, ge=0.0)  # bound of the constant error of a run


class NoiseProfile(BaseModel):
    """How wrong the sensors are; see ``robot_sim/profiles``."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    description: str = ""
    encoder_bits: int | None = Field(None, ge=8, le=32)  # counts per turn, None: exact
    derivatives: bool = False  # boards deliver joint velocity and acceleration, the IMU dgyro
    ft_force: Channel = Channel()  # N
    ft_moment: Channel = Channel()  # N m
    motor_torque: Channel = Channel()  # N m
    gyro: Channel = Channel()  # rad/s
    accelerometer: Channel = Channel()  # m/s^2
    orientation: Channel = Channel()  # rad, rotation vector
    coulomb: float = Field(0.0, ge=0.0)  # factor on the description's Coulomb friction


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


@dataclass(frozen=True)
class Block:
    """Where one channel lies in the vector of errors, and its shape."""

    part: slice
    shape: tuple[int, ...]


class Noise:
    """Errors of all sensors of one run, drawn tick by tick.

    One normal vector per tick serves every channel, which costs 2 us instead of
    one call per channel. Biases are normal with half the bound as standard
    deviation, cut at the bound.

    Args:
        profile: Size of the errors.
        n, k, m: Number of joints, force/torque sensors and inertial sensors.
        seed: The same seed gives the same errors, sample by sample.
    """

    def __init__(self, profile: NoiseProfile, n: int, k: int, m: int, seed: int):
        self.profile = profile
        self.seed = seed
        channels = {
            "ft_force": (k, 3),
            "ft_moment": (k, 3),
            "motor_torque": (n,),
            "gyro": (m, 3),
            "accelerometer": (m, 3),
            "orientation": (m, 3),
        }
        self._blocks: dict[str, Block] = {}
        size = 0
        for name, shape in channels.items():
            count = int(np.prod(shape))
            self._blocks[name] = Block(slice(size, size + count), shape)
            size += count
        self._white = self._spread(lambda channel: channel.white, size)
        self._bound = self._spread(lambda channel: channel.bias, size)
        self._step = None if profile.encoder_bits is None else 2 * np.pi / 2**profile.encoder_bits
        self.silent = not (self._white.any() or self._bound.any())
        self.restart()

    def _spread(self, value: Callable[[Channel], float], size: int) -> np.ndarray:
        spread = np.zeros(size)
        for name, block in self._blocks.items():
            spread[block.part] = value(getattr(self.profile, name))
        return spread

    def restart(self) -> None:
        """Go back to the first sample of the run: same seed, same biases, same errors."""
        self._random = np.random.default_rng(self.seed)
        bias = self._random.standard_normal(self._bound.size) * self._bound / 2
        self.bias = np.clip(bias, -self._bound, self._bound)
        self.error = np.zeros_like(self.bias)
        self.draw()

    def draw(self) -> None:
        """Draw the errors of the next sample."""
        if self.silent:
            return
        self._random.standard_normal(out=self.error)
        self.error *= self._white
        self.error += self.bias

    def on(self, channel: str) -> np.ndarray:
        """Return the present error of a channel, in its shape and unit."""
        block = self._blocks[channel]
        return self.error[block.part].reshape(block.shape)

    def encoder(self, q: np.ndarray) -> np.ndarray:
        """Return positions (n,) [rad] as the encoders count them."""
        return q.copy() if self._step is None else np.rint(q / self._step) * self._step
