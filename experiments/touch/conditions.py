"""Under which circumstances a robot is pushed."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np

PHYSICS = ("mujoco", "pinocchio")
METHODS = ("surface", "line", "particle")


@dataclass(frozen=True)
class Variant:
    """What is wrong with sensors and model, and how many pushes there are."""

    mass_error: float = 0.02  # of a link's mass in the estimator's model, at most
    tared: bool = True
    friction: float = 0.0  # N m of Coulomb friction in every joint, unknown to the estimator
    gain_error: float = 0.0  # standard deviation of each F/T channel's gain
    calibrated: bool = False  # the detector has learnt from 8 s of free motion
    contacts: str = "one"  # one; two at once on different sub-graphs (apart) or the same (together)


VARIANTS = {
    "usual": Variant(),
    "exact_masses": Variant(mass_error=0.0),
    "untared": Variant(tared=False),
    "friction": Variant(friction=0.5),
    "gain": Variant(gain_error=0.02),
    "calibrated": Variant(calibrated=True),
    "exact_masses_calibrated": Variant(mass_error=0.0, calibrated=True),
    "friction_calibrated": Variant(friction=0.5, calibrated=True),
    "gain_calibrated": Variant(gain_error=0.02, calibrated=True),
    "apart": Variant(contacts="apart"),
    "together": Variant(contacts="together"),
}


class Condition(NamedTuple):
    """One combination; a push and its noise are the same in all of them."""

    physics: str
    profile: str
    variant: str
    method: str


MIX = (  # drawn where the user names neither profile nor variant
    (0.50, "realistic", "usual"),
    (0.12, "realistic_12bit", "usual"),
    (0.10, "ideal", "exact_masses"),
    (0.10, "realistic", "apart"),
    (0.03, "realistic", "together"),
    (0.05, "realistic", "untared"),
    (0.05, "realistic", "friction"),
    (0.05, "realistic", "gain"),
)


def default_physics() -> str:
    """MuJoCo where it is installed: it shares nothing with the estimators."""
    return "mujoco" if find_spec("mujoco") else "pinocchio"


def drawn(seed: int, index: int) -> tuple[str, str]:
    """Return the profile and the variant of a run of the mixture."""
    weights = np.array([weight for weight, _, _ in MIX])
    chosen = np.random.default_rng([seed, index, 2]).choice(len(MIX), p=weights / weights.sum())
    _, profile, variant = MIX[chosen]
    return profile, variant


def checked(what: str, values: Sequence[str], known: Sequence[str]) -> None:
    """Raise ValueError when one of the values does not exist."""
    for value in values:
        if value not in known:
            raise ValueError(f"{what} must be one of {', '.join(known)}, got '{value}'")
