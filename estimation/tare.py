"""Tare of the force/torque sensors: the offsets that a resting robot reveals.

While the robot rests and nothing but its supports touches it, every sub-tree without a
support must feel no external wrench. That is one wrench equation per such sub-tree for
the offsets of the sensors that bound it. On the pole and on one foot these are as many
equations as unknowns: every offset is found. On two feet they show the arms' offsets, those
of the hip sensors relative to the foot sensors, and the sum of the feet; a load shift
between the feet looks like an offset, so their difference stays as it was.
"""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from estimation.contact_set import support_by_subtree
from estimation.oriented_graph import OrientedGraph
from estimation.resting import RestingMean, TareError
from robot_model import Robot


@dataclass(frozen=True)
class OffsetLimits:
    """What is beyond these is no offset but a contact, or a stance that was not taken."""

    force: float  # N, norm
    moment: float  # N m, norm


@dataclass(frozen=True, eq=False)
class TareResult:
    """Offsets after a tare, and what it could not see."""

    offset: np.ndarray  # (k, 6) reading minus true wrench, in the sensors' frames
    tared: tuple[str, ...]  # sensors whose six offsets were all observed
    relative: tuple[tuple[str, ...], ...]  # groups seen only in combination, by sub-tree
    unobservable: tuple[str, ...]  # sensors that share offsets which stay as they were
    supports: tuple[str, ...]

    def check(self, sensors: tuple[str, ...], limits: OffsetLimits) -> None:
        """Refuse what is too large to be an offset.

        Raises:
            TareError: Names the sensor, its offset and the limit.
        """
        bearing = " and ".join(self.supports) or "nothing"
        parts = (
            (self.offset[:, :3], limits.force, "N"),
            (self.offset[:, 3:], limits.moment, "N m"),
        )
        for offset, limit, unit in parts:
            norms = np.linalg.norm(offset, axis=1)
            worst = int(norms.argmax())
            if norms[worst] > limit:
                raise TareError(
                    f"{norms[worst]:.3g} {unit} on {sensors[worst]} is more than an offset, limit "
                    f"{limit:g} {unit}; is the robot borne by {bearing} alone?"
                )

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


def stance_supports(robot: Robot, stance: str) -> dict[int, tuple[str, ...]]:
    """Return the frames that bear the robot, by sub-tree.

    Args:
        robot: The robot.
        stance: A kind of support (``floor``, ``pole``), or one of the supports' frames
            when it stands on that alone, as ``l_sole`` does for one foot.

    Raises:
        LookupError: The robot has no such stance.
    """
    if stance in robot.supports:
        return support_by_subtree(robot, stance)
    frames = sorted({frame for frames in robot.supports.values() for frame in frames})
    if stance not in frames:
        exist = ", ".join((*robot.supports, *frames))
        raise LookupError(f"{robot.name} has no stance '{stance}'; there are: {exist}")
    return {robot.subtree_of(stance): (stance,)}


class Tare:
    """Solves for the offsets that a resting robot reveals.

    The update is the smallest one that explains the readings, where ``force_bias`` and
    ``moment_bias`` count as equally large; so what two sensors share is split evenly and
    what cannot be observed is left alone.
    """

    def __init__(self, graph: OrientedGraph, force_bias: float, moment_bias: float):
        self._graph = graph
        self._scale = np.repeat([force_bias, moment_bias], 3)  # N, N m

    def solve(self, rest: RestingMean, stance: str, offset: np.ndarray) -> TareResult:
        """Return the new offsets.

        Args:
            rest: Mean of the resting robot's samples.
            stance: See ``stance_supports``; only its frames touch anything.
            offset: Offsets until now, (k, 6).

        Raises:
            LookupError: Unknown stance.
        """
        matrix, wrench = self._equations(rest, offset)
        supports = stance_supports(self._graph.robot, stance)
        free = [s for s in range(len(wrench)) if s not in supports]
        rows = matrix[free].reshape(6 * len(free), -1)
        left, values, right = np.linalg.svd(rows)
        rank = np.count_nonzero(values > 1e-9 * values.max(initial=0.0))
        update = right[:rank].T @ (left[:, :rank].T @ wrench[free].ravel() / values[:rank])
        names = self._graph.robot.ft_sensors
        hidden = right[rank:].T.reshape(len(names), -1)
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
