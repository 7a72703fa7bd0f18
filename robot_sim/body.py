"""Rigid-body dynamics of the plant: state, external forces, acceleration, integration."""

import numpy as np
import pinocchio as pin

from robot_model import Robot, TreeModel
from robot_sim.joint_rows import joint_rows
from robot_sim.rotors import added_inertia

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
    Then v += h a and q moves by h v (semi-implicit Euler). With a clamped root, the
    root's coupling to the joints is left out.

    Args:
        robot: Gives tree and rotor inertia, see ``added_inertia``.
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
        self._mass = self.data.M  # a view: crba writes its upper triangle
        self._pivots = self.data.D  # a view: of the factorised mass
        self._added = added_inertia(robot, self.data)
        self._rotor_inertia = self._added.diagonal().copy()
        self._damping = None

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
        if damping is not self._damping:
            self._set_damping(damping)
        mass = self._mass
        mass += self._added
        self._torque[self.joint_v] = torque
        drive = self._torque - bias
        if self.fixed:
            mass[:6, 6:], drive[:6] = 0.0, 0.0
        pin.cholesky.decompose(self.model, self.data)
        if not self._pivots[self._pivots.argmin()] > 0.0:  # also true for NaN
            raise PlantDiverged(self._trouble("the mass matrix cannot be factorised"))
        self.a = pin.cholesky.solve(self.model, self.data, drive)

    def _set_damping(self, damping: Array) -> None:
        """Put h D on the diagonal; most often it is the same array at every tick."""
        self._damping = damping
        diagonal = self._rotor_inertia.copy()
        diagonal[self.joint_v] += self.tick * damping
        np.fill_diagonal(self._added, diagonal)

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
