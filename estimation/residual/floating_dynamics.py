"""Momenta, rates and known forces of a robot whose base is free, at one posture or at many."""

import numpy as np
import pinocchio as pin

from estimation.joint_friction import JointFriction
from estimation.residual.floating_terms import floating_terms
from estimation.residual.residual_model import residual_model
from robot_model import Robot

Array = np.ndarray
OWN_AXES = pin.ReferenceFrame.LOCAL


class FloatingDynamics:
    """Fills ``floating_terms`` by Pinocchio, in a frame without gravity.

    Args:
        robot: The robot; its rotors count, and its friction.
        support: Kind of support; what its sensors read is known.
    """

    def __init__(self, robot: Robot, support: str):
        self._layout = layout = residual_model(robot, support)
        self._model = model = layout.model
        model.gravity.linear = np.zeros(3)
        self.nv, self.joint_v = model.nv, layout.joint_v
        # Pinocchio's results stay where they are in memory
        self._data = data = model.createData()
        self._mass, self._coriolis = data.M, data.C
        self._q, self._v, self._acting = pin.neutral(model), np.zeros(self.nv), np.zeros(self.nv)
        # in Pinocchio's order: adding arrays of unlike orders takes four times as long
        self._rotors = np.zeros((self.nv, self.nv), order="F")
        self._rotors[np.ix_(self.joint_v, self.joint_v)] = robot.rotor_inertia
        coefficients = np.zeros((2, self.nv))
        coefficients[:, self.joint_v] = robot.viscous, robot.coulomb
        self._friction = JointFriction(*coefficients)

    def place(self, q: Array, dq: Array, torque: Array, ft: Array) -> None:
        """Take a posture and what acts: joint motion and motor torques (n,), readings (k, 6)."""
        layout, acting = self._layout, self._acting
        self._q[layout.joint_q] = q
        self._v[layout.joint_v] = dq
        pin.crba(self._model, self._data, self._q, pin.Convention.WORLD)  # fills J too
        self._mass += self._rotors
        acting[:6], acting[layout.joint_v] = 0.0, torque
        for sensor, frame in zip(layout.sensors, layout.sensor_frames, strict=True):
            # the foot on its parent: minus the reading
            acting -= ft[sensor].dot(self._jacobian(frame))

    def terms(self, twist: Array) -> Array:
        """Return the terms at the posture; ``twist`` (6,) is that of the inertial sensor.

        (3, 6 + 2 n): momenta, rates and forces.
        """
        v, imu = self._v, self._layout.imu_frame
        to_base = pin.updateFramePlacement(self._model, self._data, imu).toActionMatrix()
        v[:6] = 0.0
        v[:6] = to_base.dot(twist - self._jacobian(imu).dot(v))
        pin.computeCoriolisMatrix(self._model, self._data, self._q, v)
        friction = self._friction.torque(v)
        return floating_terms(self._mass, self._coriolis, v, friction, self._acting)

    def terms_over(self, q: Array, dq: Array, torque: Array, ft: Array, twist: Array) -> Array:
        """Return the terms of D postures, (3, D, 6 + 2 n); arguments are stacked."""
        configuration, v, acting = self._stacked(q, dq, torque)
        mass, jacobians, to_base = self._placed(configuration)
        readings = ft[:, self._layout.sensors].reshape(len(q), -1)
        acting -= np.vecmat(readings, jacobians[:, 1:].reshape(len(q), -1, self.nv))
        v[:, :6] = np.matvec(to_base, twist - np.matvec(jacobians[:, 0], v))
        coriolis = self._coriolis_of(configuration, v)
        return floating_terms(mass, coriolis, v, self._friction.torque(v), acting)

    def _jacobian(self, frame: int) -> Array:
        """Jacobian of a frame in its own axes, (6, nv)."""
        return pin.getFrameJacobian(self._model, self._data, frame, OWN_AXES)

    def _stacked(self, q: Array, dq: Array, torque: Array) -> tuple[Array, Array, Array]:
        configuration = np.tile(pin.neutral(self._model), (len(q), 1))
        configuration[:, self._layout.joint_q] = q
        v, acting = np.zeros((2, len(q), self.nv))
        v[:, self.joint_v], acting[:, self.joint_v] = dq, torque
        return configuration, v, acting

    def _placed(self, configuration: Array) -> tuple[Array, Array, Array]:
        """Return mass matrices, Jacobians of the inertial and all support sensors, and the
        maps of twists from the former to the base."""
        layout, size, nv = self._layout, len(configuration), self.nv
        frames = (layout.imu_frame, *layout.sensor_frames)
        mass, to_base = np.empty((size, nv, nv)), np.empty((size, 6, 6))
        jacobians = np.empty((size, len(frames), 6, nv))
        for i, q in enumerate(configuration):
            pin.crba(self._model, self._data, q, pin.Convention.WORLD)
            mass[i] = self._mass.T  # in the order of memory
            place = pin.updateFramePlacement(self._model, self._data, layout.imu_frame)
            to_base[i] = place.toActionMatrix()
            for j, frame in enumerate(frames):
                jacobians[i, j] = self._jacobian(frame)
        mass += self._rotors.T
        return mass, jacobians, to_base

    def _coriolis_of(self, configuration: Array, velocity: Array) -> Array:
        found = np.empty((len(velocity), self.nv, self.nv))
        for transposed, q, v in zip(found, configuration, velocity, strict=True):
            pin.computeCoriolisMatrix(self._model, self._data, q, v)
            transposed[:] = self._coriolis.T
        return found.transpose(0, 2, 1)
