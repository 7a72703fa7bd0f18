"""What touches add to a robot's equations of motion, from one sample of all sensors."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

import numpy as np
import pinocchio as pin

from estimation.contact.row_bias import RowBias
from estimation.contact.row_layout import RemovedWrenches, RowLayout
from estimation.joint_friction import JointFriction
from robot_model import Robot
from robot_model.messages import SensorFrame

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

    def __init__(self, robot: Robot, support: str = "floor"):
        self.robot = robot
        self.layout = RowLayout(robot)
        tree, self._model = self.layout.tree, self.layout.model
        self._data = self._model.createData()
        self.jacobian = self._data.J.T
        self._links = [tree.frame_id(link) for link in robot.links]
        self._q = tree.neutral.copy()
        self._v, self._a = np.zeros(self._model.nv), np.zeros(self._model.nv)
        self._joint_q, self._joint_v, self._cut_v = tree.joint_q, tree.joint_v, tree.cut_v
        self._sign = tree.cut_sign[:, None]
        swap = np.array([3, 4, 5, 0, 1, 2])
        # the force map [R 0; [p]R R] has the blocks of the motion map [R [p]R; 0 R] elsewhere
        index = 6 * self.layout.inlets[:, None, swap] + swap[None, :, None]
        self._map_index = index.reshape(-1)
        self._columns = self.jacobian.reshape(-1)
        self._force_maps = np.zeros((len(self.layout.inlets), 6, 6))  # into the root's axes
        self._friction = JointFriction(robot.viscous, robot.coulomb)
        self.predicted = np.zeros(self._model.nv)
        self.bias = RowBias(self.layout)
        self.floor = np.zeros(self._model.nv)  # variance that a calibration adds to each row
        self.set_support(support)

    def set_support(self, support: str) -> None:
        """Change the kind of support."""
        self._support_frames = self.robot.supports[support]
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
        q, v, a, dq, ddq = self._q, self._v, self._a, frame.dq, frame.ddq
        q[self._joint_q] = frame.q
        v[3:6] = frame.imu_gyro[0]
        v[self._joint_v] = dq
        a[:3] = frame.imu_acc[0]
        a[3:6] = frame.imu_dgyro[0]
        a[self._joint_v] = ddq
        rows = pin.rnea(self._model, self._data, q, v, a)
        self._put(q)
        self.predicted[:] = rows
        rows[self._joint_v] -= self._link_torque(dq, ddq, frame.motor_torque)
        rows[self._cut_v] -= frame.ft * self._sign
        rows -= self.bias.value
        return self.remove(rows, self.removed)

    @contextmanager
    def at(self, q: Array) -> Iterator[None]:
        """Take another configuration, (nq,), for a while; rows stay those of the sample."""
        present = self._q.copy()
        self._put(q)
        yield
        self._put(present)

    def _put(self, q: Array) -> None:
        self._q[:] = q
        pin.computeJointJacobians(self._model, self._data, self._q)
        self._force_maps = self._columns[self._map_index].reshape(-1, 6, 6)

    def remove(self, rows: Array, removed: RemovedWrenches) -> Array:
        """Take the net wrenches of some sub-trees from rows, (nv,), in place."""
        if removed.subtrees:
            rows -= np.vecdot(self.jacobian, removed.spread @ self._entering(rows))
        return rows

    def removal(self) -> Array:
        """The matrix P of ``remove`` for the supports at the present sample, (nv, nv)."""
        removed, nv = self.removed, self._model.nv
        back = (removed.bears[:, :, None] * self.jacobian[:, None]).reshape(nv, -1)
        return np.eye(nv) - back @ self.wrench_map(removed.subtrees).reshape(-1, nv)

    def _link_torque(self, dq: Array, ddq: Array, motor_torque: Array) -> Array:
        return motor_torque + self._friction.torque(dq) - self.robot.rotor_inertia @ ddq

    def _entering(self, rows: Array) -> Array:
        """Wrench through every inlet that rows tell, (s, 6), in the root's axes."""
        return np.matvec(self._force_maps, rows[self.layout.inlets])

    def wrenches(self, rows: Array) -> Array:
        """External wrench of every sub-tree that rows tell, (s, 6), in the root's axes."""
        return self.layout.incidence @ self._entering(rows)

    def wrench_map(self, subtrees: Sequence[int] | None = None) -> Array:
        """The matrix of ``wrenches``, (s, 6, nv), or its blocks of some sub-trees."""
        incidence = self.layout.incidence
        if subtrees is not None:
            incidence = incidence[subtrees]
        blocks = incidence[:, None, :, None] * self._force_maps.transpose(1, 0, 2)
        result = np.zeros((len(incidence), 6, self._model.nv))
        result[:, :, self.layout.inlets.reshape(-1)] = blocks.reshape(len(incidence), 6, -1)
        return result

    def place_links(self) -> list[pin.SE3]:
        """Placements of ``robot.links`` in the root's frame at the present sample."""
        return [pin.SE3(self._place(link)) for link in range(len(self._links))]

    def link_maps(self, links: Iterable[int]) -> Array:
        """Maps of wrenches from the frames of some links into the root's, (b, 6, 6)."""
        return np.array([self._place(link).toDualActionMatrix() for link in links])

    def _place(self, link: int) -> pin.SE3:
        # the Jacobians of the sample have placed the joints
        return pin.updateFramePlacement(self._model, self._data, self._links[link])
