"""The observer with its kinematic source, what it depends on, and its uncertainty."""

import numpy as np

from estimation.dependencies import ChannelDependencies, Validity
from estimation.inertial_fusion import InertialNoise
from estimation.kinematic_source import FIRST, KinematicSource
from estimation.observer_covariance import ObserverNoise, Uncertainty, propagate
from estimation.torque_observer import Estimate, TorqueObserver
from estimation.wrench_query import WrenchQuery
from robot_model.messages import SensorFrame
from services.torque_observer.config import TorqueObserverConfig
from services.torque_observer.outputs import still

Array = np.ndarray


class Observation:
    """Takes sensor frames one by one; uncertainties follow the posture now and then.

    Attributes:
        uncertainty: Of the contacts in force, at a posture of late.
        validity: Of the last estimate.
    """

    uncertainty: Uncertainty
    validity: Validity

    def __init__(self, observer: TorqueObserver, config: TorqueObserverConfig):
        self._observer, self._robot = observer, observer.robot
        self._sample: tuple[Array, ...] | None = None
        self.configure(config)

    def configure(self, config: TorqueObserverConfig) -> None:
        """Take new settings; LookupError or ValueError leaves everything as it is."""
        self._source = self._make_source(config)
        self._noise = ObserverNoise(**config.noise.model_dump())
        self._age = int(config.uncertainty_period * 1e9)
        self.follow_contacts()

    def follow_contacts(self) -> None:
        """Bring up to date what depends on where the contacts are."""
        self._dependencies = ChannelDependencies(self._observer.graph, self.source)
        q, dq, ddq, _, *inertial = still(self._robot)
        self._refresh((q, dq, ddq, *inertial), -self._age)

    def observe(self, frame: SensorFrame) -> Estimate:
        """Return the estimate; ``validity`` tells what it is worth."""
        valid = frame.imu_valid
        inertial = frame.imu_gyro[0], frame.imu_acc[0], frame.imu_dgyro[0]
        if self._source is not None:
            source = self._source.step(frame)
            inertial, valid = source.motion, np.array([source.valid])
        self._sample = frame.q, frame.dq, frame.ddq, frame.ft, *inertial
        self.validity = self._dependencies.validity(
            frame.joint_valid, frame.ft_valid, valid, frame.faults
        )
        return self._observer.step(*self._sample)

    def age(self, stamp: int) -> None:
        """Renew the uncertainty where it is too old for the sample observed last."""
        if self._sample is not None and not 0 <= stamp - self._since < self._age:
            q, dq, ddq, _, *inertial = self._sample
            self._refresh((q, dq, ddq, *inertial), stamp)

    @property
    def source(self) -> str:
        """Name of the kinematic source."""
        return self._robot.imus[0] if self._source is None else self._source.name

    def query(self) -> WrenchQuery:
        """Return answers about the last sample; ValueError when there is none."""
        if self._sample is None:
            raise ValueError("no valid sensor frame yet")
        covariance = self._source and self._source.covariance
        return WrenchQuery(self._observer, self._noise, *self._sample, source=covariance)

    def _make_source(self, config: TorqueObserverConfig) -> KinematicSource | None:
        """None where the first inertial sensor, the observer's root, is the source itself."""
        name, robot = config.kinematic_source, self._robot
        if name in (FIRST, robot.imus[0]):
            return None
        noise = InertialNoise(**config.source_noise.model_dump())
        return KinematicSource(robot, name, config.fixed_link_gravity, noise)

    def _refresh(self, motion: tuple[Array, ...], stamp: int) -> None:
        if self._source is not None:
            self._source.refresh(motion[0])
        covariance = self._source and self._source.covariance
        self.uncertainty = propagate(self._observer, self._noise, *motion, source=covariance)
        self._since = stamp
