"""A standing robot with exact sensors, pushed at its shoulders, and its residuals."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from estimation.residual.momentum_filter import MomentumFilter
from estimation.residual.residual_model import residual_model
from estimation.residual.residuals import FloatingResiduals
from estimation.sensor_pipeline import SensorPipeline
from robot_model import Robot
from robot_sim import Plant

Array = np.ndarray
GAIN = 100.0  # 1/s
SETTLE, HALF = 2.0, 1.0  # s: rest, and half a period of the force
LOCAL = pin.ReferenceFrame.LOCAL


class Push(NamedTuple):
    """A sinusoidal force at a point of a link; both in the link's frame."""

    link: str
    point: Array  # m
    force: Array  # N, amplitude


class Trace(NamedTuple):
    """Residuals and true values at T instants; generalised forces are [base, joints]."""

    time: Array  # (T,) s
    internal: Array  # (T, n) N m
    external: Array  # (T, 6) in base axes
    classical: Array  # (T, n)
    true_internal: Array  # (T, n) J_fb^T f, R eq. (12)
    true_virtual: Array  # (T, 6 + n) J^T f, of the model with virtual joints (8)
    filtered: Array  # (T, n) true_internal through the residuals' filter
    forces: Array  # (T, pushes, 3) true, in base axes
    virtual_map: Array  # (T, 6 + n, 3 pushes) from these forces to J^T f
    internal_map: Array  # (T, n, 3 pushes) to J_fb^T f


class ResidualTruth:
    """What residuals should be, from the plant's state and forces.

    On the residuals' model: without what lies below the sensors of the supports, with rotors.
    """

    def __init__(self, robot: Robot, support: str = "floor"):
        layout = residual_model(robot, support)
        self._robot, self._layout, self._model = robot, layout, layout.model
        self._data = self._model.createData()
        self._q = pin.neutral(self._model)
        self._rotors = np.zeros((self._model.nv,) * 2)
        self._rotors[np.ix_(layout.joint_v, layout.joint_v)] = robot.rotor_inertia

    def maps(self, q: Array, pushes: list[Push]) -> tuple[Array, Array]:
        """Return J^T (6 + n, 3 c) and J_fb^T (n, 3 c) for forces in base axes, joints in the
        description's order."""
        model, data, rows = self._model, self._data, self._layout.joint_v
        self._q[self._layout.joint_q] = q
        mass = pin.crba(model, data, self._q, pin.Convention.WORLD)
        mass = np.triu(mass) + np.triu(mass, 1).T + self._rotors
        pin.computeJointJacobians(model, data, self._q)
        virtual = np.hstack([self._jacobian(push).T for push in pushes])
        gives = np.linalg.solve(mass[:6, :6], mass[:6, 6:])
        internal = virtual.copy()
        internal[6:] -= gives.T @ virtual[:6]
        return np.vstack((virtual[:6], virtual[rows])), internal[rows]

    def _jacobian(self, push: Push) -> Array:
        """Jacobian of the point in base axes, (3, nv); the base's placement is the identity."""
        frame = self._model.getFrameId(push.link)
        place = pin.updateFramePlacement(self._model, self._data, frame)
        to_point = np.hstack((np.eye(3), -pin.skew(push.point)))
        columns = pin.getFrameJacobian(self._model, self._data, frame, LOCAL)
        return place.rotation @ to_point @ columns

    def placements(self, q: Array) -> dict[str, pin.SE3]:
        """Placements of the links in base axes, at the joints' positions (n,)."""
        model, data = self._model, self._data
        self._q[self._layout.joint_q] = q
        pin.framesForwardKinematics(model, data, self._q)
        return {link: data.oMf[model.getFrameId(link)].copy() for link in self._robot.links}


def pushed(robot: Robot, pushes: list[Push], settle: float = SETTLE, half: float = HALF) -> Trace:
    """Let the robot stand, then push it for a period of the sinusoid, all places in phase.

    The trace begins 0.2 s before the push; ``settle`` and ``half`` a period in seconds.
    """
    plant, pipeline = Plant(robot, "free", "ideal"), SensorPipeline(robot)
    residuals = FloatingResiduals(robot, "floor", GAIN, GAIN)
    truth, smooth = ResidualTruth(robot), MomentumFilter(robot.n, GAIN)
    rows: list[tuple] = []
    impulse = np.zeros(robot.n)
    start, length = round(1000 * settle), round(1000 * half)
    for tick in range(start + round(2.2 * length)):
        if tick in (start, start + length):
            _push(plant, pushes, 1.0 if tick == start else -1.0, half)
        plant.step()
        frame = pipeline.step(plant.raw(), plant.time)
        inertial = frame.imu_gyro[0], frame.imu_acc[0]
        residuals.step(frame.q, frame.dq, frame.motor_torque, frame.ft, *inertial, 1e-3)
        if tick < start - 200:
            continue
        virtual, internal = truth.maps(frame.q, pushes)
        forces = _forces(plant, pushes)
        real = internal @ forces.reshape(-1)
        impulse = impulse + 1e-3 * real
        filtered = smooth.step(impulse, np.zeros(robot.n), 1e-3).copy()
        sample = residuals.sample
        rows.append(
            (plant.time * 1e-9, sample.internal, sample.external, sample.classical, real,
             virtual @ forces.reshape(-1), filtered, forces, virtual, internal)
        )  # fmt: skip
    return Trace(*(np.array(column) for column in zip(*rows, strict=True)))


def _push(plant: Plant, pushes: list[Push], sign: float, half: float) -> None:
    """Begin half a sine, there or back."""
    for push in pushes:
        force = sign * push.force
        plant.push(push.link, push.point, force, profile="half_sine", duration=half)


def _forces(plant: Plant, pushes: list[Push]) -> Array:
    """True forces in base axes, (c, 3)."""
    x, y, z, w = plant.truth().base_quat_wxyz[[1, 2, 3, 0]]
    base_from_world = pin.Quaternion(w, x, y, z).toRotationMatrix().T
    found = {one["link"]: np.array(one["force_world"]) for one in plant.truth().pushes}
    return np.array([base_from_world @ found.get(push.link, np.zeros(3)) for push in pushes])
