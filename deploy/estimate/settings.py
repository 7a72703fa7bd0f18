"""The services' own settings, so that a log gives what they say live."""

from typing import NamedTuple

from bus.configuration import load
from services.base_estimator.config import BaseEstimatorConfig
from services.contact_detector.config import ContactDetectorConfig
from services.sensor_server.config import FilterConfig, SensorServerConfig
from services.torque_observer.config import TorqueObserverConfig


class Settings(NamedTuple):
    """What each step of the estimate is set to."""

    filter: FilterConfig
    observer: TorqueObserverConfig
    contacts: ContactDetectorConfig
    base: BaseEstimatorConfig


def default_settings() -> Settings:
    """Return the packaged settings of the services."""
    return Settings(
        load(SensorServerConfig, "services.sensor_server").filter,
        load(TorqueObserverConfig, "services.torque_observer"),
        load(ContactDetectorConfig, "services.contact_detector"),
        load(BaseEstimatorConfig, "services.base_estimator"),
    )
