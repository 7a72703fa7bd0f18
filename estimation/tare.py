"""Tare of the force/torque sensors: the offsets that a resting robot reveals.

While the robot rests and nothing but its supports touches it, every sub-tree without a
support must feel no external wrench. That is one wrench equation per such sub-tree for
the offsets of the sensors that bound it. On two feet this shows the arms' offsets, those
of the hip sensors relative to the foot sensors, and the sum of the feet; a load shift
between the feet looks like an offset, so their difference stays as it was.
"""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
import scipy.linalg

from estimation.contact_set import support_by_subtree
from estimation.oriented_graph import OrientedGraph


class MovingError(RuntimeError):
    """The robot moved while it had to rest."""


@dataclass(frozen=True)
class StillnessLimits:
    """A robot that exceeds one of these moves. Root mean squares over the window."""

    joint_velocity: float  # rad/s, of any joint
    joint_travel: float  # rad, between the extremes of any joint
    angular_velocity: float  # rad/s, norm of the gyro's reading, its bias included


@dataclass(frozen=True, eq=False)
class RestingMean:
    """Mean sample of a resting robot."""

    q: np.ndarray  # (n,) rad
    ft: np.ndarray  # (k, 6) raw readings
    acc: np.ndarray  # (3,) m/s^2
    samples: int


class RestingAverage:
    """Collects samples while the robot rests."""

    def __init__(self, joints: tuple[str, ...], limits: StillnessLimits):
        self._joints = joints
        self._limits = limits
        self._count = 0

    def add(
        self, q: np.ndarray, dq: np.ndarray, ft: np.ndarray, gyro: np.ndarray, acc: np.ndarray
    ) -> None:
        """Add one sample: (n,), (n,), (k, 6), (3,), (3,)."""
        if self._count == 0:
            self._sums = [np.zeros_like(x) for x in (q, dq, ft, acc)]
            self._turning = 0.0
            self._lowest = self._highest = q
        for total, value in zip(self._sums, (q, dq * dq, ft, acc), strict=True):
            total += value
        self._turning += float(gyro @ gyro)
        self._lowest, self._highest = np.minimum(self._lowest, q), np.maximum(self._highest, q)
        self._count += 1

    def mean(self) -> RestingMean:
        """Return the mean.

        Raises:
            MovingError: Something moved, or no sample came.
        """
        if self._count == 0:
            raise MovingError("no complete sample came; tare needs every sensor")
        q, squares, ft, acc = (total / self._count for total in self._sums)
        self._check(np.sqrt(squares), np.sqrt(self._turning / self._count))
        return RestingMean(q, ft, acc, self._count)

    def _check(self, velocity: np.ndarray, turning: float) -> None:
        limits, fastest = self._limits, int(velocity.argmax())
        travel = self._highest - self._lowest
        farthest = int(travel.argmax())
        if velocity[fastest] > limits.joint_velocity:
            what = f"{self._joints[fastest]} at {velocity[fastest]:.3f} rad/s"
            raise MovingError(f"the robot moves: {what}, limit {limits.joint_velocity} rad/s")
        if travel[farthest] > limits.joint_travel:
            what = f"{self._joints[farthest]} by {travel[farthest]:.3f} rad"
            raise MovingError(f"the robot moves: {what}, limit {limits.joint_travel} rad")
        if turning > limits.angular_velocity:
            limit = limits.angular_velocity
            raise MovingError(f"the robot turns at {turning:.3f} rad/s, limit {limit} rad/s")


@dataclass(frozen=True, eq=False)
class TareResult:
    """Offsets after a tare, and what it could not see."""

    offset: np.ndarray  # (k, 6) reading minus true wrench, in the sensors' frames
    tared: tuple[str, ...]  # sensors whose six offsets were all observed
    relative: tuple[tuple[str, ...], ...]  # groups seen only in combination, by sub-tree
    unobservable: tuple[str, ...]  # sensors that share offsets which stay as they were
    supports: tuple[str, ...]

    @property
    def message(self) -> str:
        """Say in a sentence what was tared and what stays."""
        parts = [f"tared: {', '.join(self.tared) or 'no sensor by itself'}"]
        if self.relative:
            groups = [" with ".join(group) for group in self.relative]
            parts.append(f"only in combination: {'; '.join(groups)}")
        if self.unobservable:
            parts.append(
                f"offsets of {', '.join(self.unobservable)} that look like a shift of load "
                f"between {' and '.join(self.supports)} cannot be observed and stay"
            )
        return "; ".join(parts)


class Tare:
    """Solves for the offsets that a resting robot reveals.

    The update is the smallest one that explains the readings, where ``force_bias`` and
    ``moment_bias`` count as equally large; so what two sensors share is split evenly and
    what cannot be observed is left alone.
    """

    def __init__(self, graph: OrientedGraph, force_bias: float, moment_bias: float):
        self._graph = graph
        self._scale = np.repeat([force_bias, moment_bias], 3)  # N, N m

    def solve(self, rest: RestingMean, support: str, offset: np.ndarray) -> TareResult:
        """Return the new offsets.

        Args:
            rest: Mean of the resting robot's samples.
            support: Kind of support; only its frames touch anything.
            offset: Offsets until now, (k, 6).
        """
        matrix, wrench = self._equations(rest, offset)
        supports = support_by_subtree(self._graph.robot, support)
        free = [s for s in range(len(wrench)) if s not in supports]
        rows = matrix[free].reshape(6 * len(free), -1)
        update = np.linalg.pinv(rows, rcond=1e-9) @ wrench[free].ravel()
        names = self._graph.robot.ft_sensors
        hidden = scipy.linalg.null_space(rows, rcond=1e-9).reshape(len(names), -1)
        unseen = np.abs(hidden).max(axis=1, initial=0.0) > 1e-6
        return TareResult(
            offset=offset + update.reshape(-1, 6) * self._scale,
            tared=tuple(name for name, out in zip(names, unseen, strict=True) if not out),
            relative=self._groups(free, unseen),
            unobservable=tuple(name for name, out in zip(names, unseen, strict=True) if out),
            supports=tuple(frame for frames in supports.values() for frame in frames),
        )

    def _groups(self, free: list[int], unseen: np.ndarray) -> tuple[tuple[str, ...], ...]:
        """Sensors around each free sub-tree that are not observed by themselves."""
        names = self._graph.robot.ft_sensors
        around = self._graph.subtree_sensors() & unseen
        groups = (tuple(names[i] for i in np.flatnonzero(around[s])) for s in free)
        return tuple(group for group in groups if group)

    def _equations(self, rest: RestingMean, offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return A (s, 6, 6 k) and b (s, 6) with A (scaled update) = b for a free sub-tree.

        b is the external wrench that the sub-tree seems to feel, about the root frame.
        """
        graph = self._graph
        tree, bare, q = graph.tree, graph.bare_model, graph.neutral.copy()
        q[tree.joint_q] = rest.q
        a = np.zeros(bare.nv)
        a[:3] = rest.acc
        tau = pin.rnea(bare, graph.bare_data, q[: bare.nq], np.zeros(bare.nv), a)
        jacobian = pin.computeJointJacobians(graph.model, graph.data, q)
        maps = np.linalg.inv(jacobian[:, tree.cut_v].transpose(1, 2, 0))
        sign = tree.cut_sign[:, None]
        through = np.vstack([tau[:6], tau[tree.cut_v] - sign * (rest.ft - offset)])
        through[1:] = np.einsum("kij,kj->ki", maps, through[1:])
        effect = -sign[:, :, None] * maps * self._scale
        matrix = np.einsum("sk,kij->sikj", graph.incidence[:, 1:], effect)
        return matrix.reshape(len(through), 6, -1), graph.incidence @ through
