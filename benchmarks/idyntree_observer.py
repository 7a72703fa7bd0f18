"""The peer: iDynTree's estimator of external wrenches and joint torques, NumPy to NumPy."""

import warnings
from collections.abc import Sequence

import numpy as np

from estimation.torque_observer import TorqueObserver
from robot_model import Robot
from robot_model.messages import SensorFrame

with warnings.catch_warnings():
    # SWIG's types warn at import; where warnings are errors, the import would crash.
    warnings.simplefilter("ignore", DeprecationWarning)
    import idyntree.swig as idyn


class IdyntreeObserver:
    """ExtWrenchesAndJointTorquesEstimator with one full unknown wrench per contact frame.

    Args:
        robot: Gives URDF, joint order, sensors and the inertial sensor.
        frames: Contact frames, one per sub-tree.
    """

    def __init__(self, robot: Robot, frames: Sequence[str]):
        self._estimator = idyn.ExtWrenchesAndJointTorquesEstimator()
        names = idyn.StringVector(list(robot.joints))
        urdf = str(robot.urdf.path)
        if not self._estimator.loadModelAndSensorsFromFileWithSpecifiedDOFs(urdf, names):
            raise RuntimeError(f"iDynTree cannot load {urdf}")
        model = self._estimator.model()
        self._imu = model.getFrameIndex(robot.imus[0])
        sensors = self._estimator.sensors()
        kind = idyn.SIX_AXIS_FORCE_TORQUE
        self._sensor_index = [sensors.getSensorIndex(kind, name) for name in robot.ft_sensors]
        self._readings = idyn.SensorsMeasurements(sensors)
        self._unknowns = idyn.LinkUnknownWrenchContacts(model)
        self._wrenches = idyn.LinkContactWrenches(model)
        self._torques = idyn.JointDOFsDoubleArray(model)
        self._add_contacts(model, frames)

    @classmethod
    def like(cls, robot: Robot) -> "IdyntreeObserver":
        """Return the peer of the torque observer with its default contacts."""
        return cls(robot, [contact.frame for contact in TorqueObserver(robot).contacts])

    def _add_contacts(self, model: idyn.Model, frames: Sequence[str]) -> None:
        self._links, rotations = [], []
        for frame in frames:
            index = model.getFrameIndex(frame)
            self._unknowns.addNewUnknownFullWrenchInFrameOrigin(model, index)
            self._links.append(model.getFrameLink(index))
            rotations.append(model.getFrameTransform(index).getRotation().toNumPy())
        self._rotations = np.array(rotations)  # R_link_frame

    def step(
        self,
        q: np.ndarray,
        dq: np.ndarray,
        ddq: np.ndarray,
        ft: np.ndarray,
        gyro: np.ndarray,
        acc: np.ndarray,
        dgyro: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return torques (n,) and wrenches (c, 6) in the axes of the contacts' links.

        Arguments as ``TorqueObserver.step``. Both peers are handed their own sign of
        ``ft``: iDynTree's is the child on the parent.
        """
        motion = (
            idyn.JointPosDoubleArray.FromPython(q),
            idyn.JointDOFsDoubleArray.FromPython(dq),
            idyn.JointDOFsDoubleArray.FromPython(ddq),
        )
        inertial = [idyn.Vector3.FromPython(value) for value in (acc, gyro, dgyro)]
        kind = idyn.SIX_AXIS_FORCE_TORQUE
        for index, reading in zip(self._sensor_index, ft, strict=True):
            self._readings.setMeasurement(kind, index, idyn.Wrench.FromPython(reading))
        self._estimator.updateKinematicsFromFloatingBase(*motion, self._imu, *inertial)
        self._estimator.estimateExtWrenchesAndJointTorques(
            self._unknowns, self._readings, self._wrenches, self._torques
        )
        wrenches = np.array(
            [self._wrenches.contactWrench(i, 0).contactWrench.toNumPy() for i in self._links]
        )
        return self._torques.toNumPy(), wrenches

    def step_frame(self, frame: SensorFrame) -> tuple[np.ndarray, np.ndarray]:
        """The same for a sensor frame, whose ``ft`` is the parent on the child."""
        motion = frame.q, frame.dq, frame.ddq
        inertial = frame.imu_gyro[0], frame.imu_acc[0], frame.imu_dgyro[0]
        return self.step(*motion, -frame.ft, *inertial)

    def in_frame_axes(self, wrenches: np.ndarray) -> np.ndarray:
        """Turn wrenches (c, 6) from link axes to the axes of the contact frames."""
        parts = wrenches.reshape(-1, 2, 3) @ self._rotations
        return parts.reshape(-1, 6)
