"""Run the torque observer: ``python -m services.torque_observer``."""

from bus.service import serve
from robot_model import ports, robot_name
from services.torque_observer.config import TorqueObserverConfig
from services.torque_observer.service import main

serve(
    main,
    TorqueObserverConfig,
    name="torque_observer",
    package=__package__,
    clock_port=lambda config: ports.name("clock", robot_name(config.robot)),
)
