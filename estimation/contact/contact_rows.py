"""What touches add to a robot's equations of motion, from one sample of all sensors."""

from collections.abc import Iterable, Sequence

import numpy as np
import pinocchio as pin

from estimation.contact.row_bias import RowBias
from estimation.contact.row_layout import RemovedWrenches, RowLayout
from estimation.joint_friction import JointFriction
from robot_model import Robot
from robot_model.messages import SensorFrame
from robot_model.tree import TreeModel

Array = np.ndarray


class ContactRows:
    """Rows r = J^T F of the touches: inverse dynamics minus what is measured.

    The rows are those of the base, the joints, and the six of each force/torque sensor.
    Motor torques become link torques (rotors and friction taken off). The supports'
    wrenches are removed, and what ``bias`` says.

    After ``update``, ``predicted`` (nv,; what the model alone says), ``jacobian`` (nv, 6;
    row = motion axis [v w] in the root's axes) and ``wrenches()`` belong to that sample.
    The root is the first inertial sensor; wrenches are in its axes, about its origin.
    """

    def __init__(self, robot: Robot, support: str = "floor", layout: RowLayout | None = None):
        self.robot = robot
        self.layout = layout or RowLayout(robot)
        tree, self._model = self.layout.tree, self.layout.model
        self._data = self._model.createData()
        self.jacobian = self._data.J.T
        self._links = [tree.frame_id(link) for link in robot.links]
        self._q = tree.neutral.copy()
        self._v, self._a = np.zeros(self._model.nv), np.zeros(self._model.nv)
        self._joint_q, self._joint_v = tree.joint_q, tree.joint_v
        swap = np.array([3, 4, 5, 0, 1, 2])
        # the force map [R 0; [p]R R] has the blocks of the motion map [R [p]R; 0 R] elsewhere
        index = 6 * self.layout.inlets[:, None, swap] + swap[None, :, None]
        self._map_index = index.reshape(-1)
        self._columns = self.jacobian.reshape(-1)
        self._force_maps = np.zeros((len(self.layout.inlets), 6, 6))  # into the root's axes
        self._friction = JointFriction(robot.viscous, robot.coulomb)
        self._telling = _telling(robot, tree)
        self.predicted = np.zeros(self._model.nv)
        self.bias = RowBias(self.layout)
        self.floor: Array | None = None  # (nv,) variance of the rows that a calibration found
        self.set_support(support)

    def set_support(self, support: str) -> None:
        """Change the kind of support."""
        self.support, self._support_frames = support, self.robot.supports[support]
        self._removing: dict[tuple[int, ...], RemovedWrenches] = {}
        self.removed = self.removing(())

    def removing(self, blind: Iterable[int]) -> RemovedWrenches:
        """Return what is removed when some sub-trees shall not disturb the others."""
        key = tuple(blind)
        if key not in self._removing:
            self._removing[key] = RemovedWrenches(self.layout, self._support_frames, key)
        return self._removing[key]

    @property
    def q(self) -> Array:
        """Pinocchio's configuration of the present sample, (nq,)."""
        return self._q

    def update(self, frame: SensorFrame) -> Array:
        """Take one sample and return the rows of the touches, (nv,) [N, N m]."""
        q, v, a = self._q, self._v, self._a
        q[self._joint_q] = frame.q
        v[3:6] = frame.imu_gyro[0]
        v[self._joint_v] = frame.dq
        a[:3] = frame.imu_acc[0]
        a[3:6] = frame.imu_dgyro[0]
        a[self._joint_v] = frame.ddq
        rows = pin.rnea(self._model, self._data, q, v, a)
        self.put(q)
        self.predicted[:] = rows
        rows -= self._measured(frame)
        rows -= self.bias.value
        return self.remove(rows, self.removed)

    def stand(self, frame: SensorFrame) -> None:
        """Take the posture of a frame without a sample."""
        self._q[self._joint_q] = frame.q
        self.put(self._q)

    def put(self, q: Array) -> None:
        """Take a configuration, (nq,), without a sample."""
        self._q[:] = q
        pin.computeJointJacobians(self._model, self._data, self._q)
        self._force_maps = self._columns[self._map_index].reshape(-1, 6, 6)

    def remove(self, rows: Array, removed: RemovedWrenches) -> Array:
        """Take the net wrenches of some sub-trees from rows, (nv,), in place."""
        if removed.subtrees:
            rows -= np.vecdot(self.jacobian, removed.spread.dot(self._entering(rows)))
        return rows

    def removal(self) -> Array:
        """The matrix P of ``remove`` for the supports at the present sample, (nv, nv)."""
        removed, nv = self.removed, self._model.nv
        back = (removed.bears[:, :, None] * self.jacobian[:, None]).reshape(nv, -1)
        return np.eye(nv) - back @ self.wrench_map(removed.subtrees).reshape(-1, nv)

    def _measured(self, frame: SensorFrame) -> Array:
        """What motors, rotors, friction and force/torque sensors tell of the rows, (nv,)."""
        torque = frame.motor_torque + self._friction.torque(frame.dq)
        return self._telling.dot(np.concatenate((torque, frame.ddq, frame.ft.reshape(-1))))

    def _entering(self, rows: Array) -> Array:
        """Wrench through every inlet that rows tell, (…, s, 6), in the root's axes."""
        return np.matvec(self._force_maps, rows.take(self.layout.inlets, axis=-1))

    def wrenches(self, rows: Array) -> Array:
        """External wrench of every sub-tree that rows, (…, nv), tell, (…, s, 6).

        In the root's axes.
        """
        return self.layout.incidence @ self._entering(rows)

    def wrench_map(self, subtrees: Sequence[int] | None = None) -> Array:
        """The matrix of ``wrenches``, (s, 6, nv), or its blocks of some sub-trees."""
        blocks = self.wrench_blocks()
        if subtrees is not None:
            blocks = blocks[subtrees]
        result = np.zeros((len(blocks), 6, self._model.nv))
        result[:, :, self.layout.inlets.reshape(-1)] = blocks
        return result

    def wrench_blocks(self) -> Array:
        """The columns of ``wrench_map`` that are not zero: those of the inlets, (s, 6, 6 s)."""
        incidence = self.layout.incidence[:, None, :, None]
        blocks = incidence * self._force_maps.transpose(1, 0, 2)
        return blocks.reshape(len(blocks), 6, -1)

    def place_links(self) -> list[pin.SE3]:
        """Placements of ``robot.links`` in the root's frame at the present sample."""
        return [pin.SE3(self._place(link)) for link in range(len(self._links))]

    def link_maps(self, links: Iterable[int]) -> Array:
        """Maps of wrenches from the frames of some links into the root's, (b, 6, 6)."""
        return np.array([self._place(link).toDualActionMatrix() for link in links])

    def _place(self, link: int) -> pin.SE3:
        # the Jacobians of the sample have placed the joints
        return pin.updateFramePlacement(self._model, self._data, self._links[link])


def _telling(robot: Robot, tree: TreeModel) -> Array:
    """Return the map from [link torques before the rotors, ddq, readings] to rows."""
    n, cuts = robot.n, tree.cut_v.reshape(-1)
    result = np.zeros((tree.model.nv, 2 * n + len(cuts)))
    result[tree.joint_v, np.arange(n)] = 1.0
    result[tree.joint_v, n : 2 * n] = -robot.rotor_inertia
    result[cuts, np.arange(2 * n, result.shape[1])] = np.repeat(tree.cut_sign, 6)
    return result
