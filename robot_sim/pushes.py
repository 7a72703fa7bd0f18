"""Pushes: forces that somebody's finger exerts on a link for a while."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pinocchio as pin

from robot_model import Robot
from robot_sim.contact import placement

Array = np.ndarray
Profile = Literal["hold", "ramp", "half_sine"]
PROFILES: tuple[Profile, ...] = ("hold", "ramp", "half_sine")
RISE = 0.5  # s, longest rise of a ramp


@dataclass(frozen=True)
class PushShape:
    """How a push rises and falls.

    ``hold`` acts at full force; ``ramp`` rises over ``rise`` (half the duration when that
    is shorter) and then holds; ``half_sine`` rises and falls within the duration. The
    first two may last until they are released.

    Raises:
        ValueError: unknown profile, or a time that makes no sense.
    """

    profile: str = "hold"  # one of PROFILES
    duration: float = np.inf  # s, infinite until released
    rise: float = RISE  # s, of a ramp

    def __post_init__(self):
        if self.profile not in PROFILES:
            known = ", ".join(PROFILES)
            raise ValueError(f"profile must be one of {known}, got {self.profile!r}")
        endless = self.profile == "half_sine" and self.duration == np.inf
        if not self.duration > 0.0 or endless:
            raise ValueError(
                f"a {self.profile} push needs a positive duration [s], got {self.duration}"
            )
        if not 0.0 < self.rise < np.inf:
            raise ValueError(f"a ramp needs a positive rise [s], got {self.rise}")

    def amplitude(self, elapsed: float) -> float:
        """Return the factor on the force, 0 to 1, some seconds after the start."""
        if self.profile == "half_sine":
            return float(np.sin(np.pi * elapsed / self.duration))
        if self.profile == "ramp":
            return min(1.0, elapsed / min(self.rise, self.duration / 2))
        return 1.0

    def ended(self, elapsed: float) -> bool:
        return elapsed >= self.duration


@dataclass(frozen=True, eq=False)
class Push:
    """One push; ``point`` in the link frame [m], ``force`` in ``frame`` [N]."""

    id: int
    link: str
    point: Array
    force: Array
    frame: Literal["link", "world"]
    shape: PushShape
    start: float  # s
    joint: int  # that carries the link in the whole tree
    joint_M_link: pin.SE3
    wrench_map: Array  # (6, 3), force in the joint's axes to wrench on the joint
    joint_cut: int  # the same in the tree cut at the F/T sensors
    wrench_map_cut: Array  # (6, 3), force in the whole tree's joint axes


class Pushes:
    """The pushes that act now."""

    def __init__(self, robot: Robot, data: pin.Data, cut):
        self._robot = robot
        self._data = data
        self._cut = cut
        self._next = 1
        self.active: list[Push] = []
        self.acting: list[tuple[Push, Array]] = []  # with its force in the joint's axes

    def restart(self) -> None:
        """Forget all pushes; ids start again."""
        self._next = 1
        self.active, self.acting = [], []

    def add(
        self,
        link: str,
        point: Array,
        force: Array,
        frame: str,
        shape: PushShape,
        start: float,
    ) -> int:
        """Add a push and return its id. Errors are those of ``Plant.push``."""
        self._robot.require_link(link)
        if frame not in ("link", "world"):
            raise ValueError(f"frame must be 'link' or 'world', got {frame!r}")
        point, force = _vector3("point", point), _vector3("force", force)
        whole = placement(self._robot.tree.model, self._robot.tree.frame_id(link))
        part = placement(self._cut.model, self._cut.frame_id(link))
        turn = part.joint_M_frame.rotation @ whole.joint_M_frame.rotation.T
        push = Push(
            self._next, link, point, force, frame, shape, start,
            whole.joint, whole.joint_M_frame, _wrench_map(whole.joint_M_frame.act(point)),
            part.joint, _wrench_map(part.joint_M_frame.act(point)) @ turn,
        )  # fmt: skip
        self._next += 1
        self.active.append(push)
        return push.id

    def release(self, push_id: int | None = None) -> list[int]:
        """End one push, or all; returns the ids that ended.

        Raises:
            LookupError: no such push acts now.
        """
        ended = [push.id for push in self.active if push_id in (None, push.id)]
        if push_id is not None and not ended:
            acting = ", ".join(str(push.id) for push in self.active) or "none"
            raise LookupError(f"push {push_id} does not act now; acting: {acting}")
        self.active = [push for push in self.active if push.id not in ended]
        return ended

    def evaluate(self, time: float) -> None:
        """Find the forces that act at a time [s], from the placements in ``data``."""
        self.active = [push for push in self.active if not push.shape.ended(time - push.start)]
        self.acting = [(push, self._joint_force(push, time)) for push in self.active]

    def _joint_force(self, push: Push, time: float) -> Array:
        if push.frame == "link":
            force = push.joint_M_link.rotation @ push.force
        else:
            force = self._data.oMi[push.joint].rotation.T @ push.force
        return push.shape.amplitude(time - push.start) * force

    def truth(self) -> list[dict[str, Any]]:
        """Return the pushes as GroundTruth carries them."""
        return [
            {
                "id": push.id,
                "link": push.link,
                "point": push.point.tolist(),
                "force_world": (self._data.oMi[push.joint].rotation @ force).tolist(),
            }
            for push, force in self.acting
        ]


def _wrench_map(point: Array) -> Array:
    return np.vstack([np.eye(3), pin.skew(point)])


def _vector3(what: str, value: Array) -> Array:
    array = np.array(value, dtype=float)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise ValueError(f"{what} must be 3 finite numbers, got {value}")
    return array
