"""Rigid-body dynamics of the plant: state, external forces, acceleration, integration."""

import numpy as np
import pinocchio as pin
from scipy.linalg.lapack import dposv  # pyright: ignore[reportAttributeAccessIssue]

from robot_model import Robot, TreeModel
from robot_sim.joint_rows import joint_rows

Array = np.ndarray

SPEED_LIMIT = 1e3  # rad/s and m/s; nothing sane comes near


class PlantDiverged(RuntimeError):
    """The integration blew up; the plant must be reset."""


class ExternalForces:
    """External wrenches [f m] by joint of a tree, in the joint's axes about its origin."""

    def __init__(self, model: pin.Model):
        self.list = pin.StdVec_Force()
        for _ in range(model.njoints):
            self.list.append(pin.Force.Zero())
        self._rows = joint_rows(self.list)

    def clear(self) -> None:
        self._rows.fill(0.0)

    def add(self, joint: int, wrench: Array) -> None:
        row = self._rows[joint]
        row += wrench


class Body:
    """State and forward dynamics of a free-floating tree, or with its root clamped.

    Solves (M + A + h D) a = tau - D v - bias + J' f, so viscous damping D acts at the
    end of the tick and stays stable however large it is; A is the rotor inertia.
    Then v += h a and q moves by h v (semi-implicit Euler).

    Args:
        robot: Gives tree and rotor inertia.
        tick: Integration step h [s].

    Attributes:
        q, v, a: Configuration (nq,), velocity and acceleration (nv,) of ``robot.tree``.
        forces: External wrenches of the present instant.
    """

    def __init__(self, robot: Robot, tick: float):
        tree: TreeModel = robot.tree
        self.model = tree.model
        self.data = tree.model.createData()
        self.tick = tick
        self.fixed = False
        self.forces = ExternalForces(tree.model)
        self.q = tree.neutral.copy()
        self.v = np.zeros(self.model.nv)
        self.a = np.zeros(self.model.nv)
        self.joint_v = tree.joint_v
        self._zero = np.zeros(self.model.nv)
        self._torque = np.zeros(self.model.nv)
        self._inertia = np.zeros((self.model.nv, self.model.nv), order="F")  # like the mass
        self._inertia[np.ix_(tree.joint_v, tree.joint_v)] = robot.rotor_inertia
        self._mass = self.data.M  # a view: crba writes into it
        self._matrix = np.zeros_like(self._inertia)
        self._diagonal = self._matrix.T.reshape(-1)[:: self.model.nv + 1]
        self._damping = np.zeros(self.model.nv)

    def place(self, q: Array, fixed: bool) -> None:
        """Put the body at rest at a configuration (nq,), with a clamped or a free root."""
        self.q, self.fixed = q.copy(), fixed
        self.halt()
        self.forces.clear()
        self.update_kinematics()

    def halt(self) -> None:
        """Stop all motion."""
        self.v, self.a = self._zero.copy(), self._zero.copy()

    def update_kinematics(self) -> None:
        """Bring placements and velocities in ``data`` up to the present state."""
        pin.forwardKinematics(self.model, self.data, self.q, self.v)

    def accelerate(self, torque: Array, damping: Array) -> None:
        """Find the acceleration of the present state.

        Args:
            torque: Torque on the joints at this instant, all friction included,
                (n,) [N m].
            damping: Its slope against joint velocity, made positive, (n,) [N m s/rad].

        Raises:
            PlantDiverged: the mass matrix is no longer positive definite.
        """
        bias = pin.rnea(self.model, self.data, self.q, self.v, self._zero, self.forces.list)
        pin.crba(self.model, self.data, self.q)
        matrix = self._matrix
        np.add(self._mass, self._inertia, out=matrix)
        self._damping[self.joint_v] = self.tick * damping
        self._diagonal += self._damping
        self._torque[self.joint_v] = torque
        drive = self._torque - bias
        if self.fixed:
            _, self.a[6:], status = dposv(matrix[6:, 6:], drive[6:])
        else:
            _, self.a, status = dposv(matrix, drive, overwrite_a=1, overwrite_b=1)
        if status != 0:
            raise PlantDiverged(self._trouble("the mass matrix cannot be factorised"))

    def integrate(self) -> None:
        """Move the state by one tick with the present acceleration.

        Raises:
            PlantDiverged: the velocity is not finite or its norm is beyond 1e3.
        """
        v = self.v + self.tick * self.a
        if not (v.dot(v) < SPEED_LIMIT**2):  # also true for NaN
            self.v = v
            raise PlantDiverged(self._trouble("a velocity left all bounds"))
        self.v = v
        self.q = pin.integrate(self.model, self.q, self.tick * v)

    def _trouble(self, what: str) -> str:
        speed = np.where(np.isfinite(self.v), np.abs(self.v), np.inf)
        worst = int(np.argmax(speed))
        joints = self.model.joints[1:]
        index = next(i for i, j in enumerate(joints, 1) if worst < j.idx_v + j.nv)
        return (
            f"{what}: fastest is {self.model.names[index]!r} with {self.v[worst]:.3g} "
            f"(limit {SPEED_LIMIT:g}); board gains too high, or a push too hard?"
        )
