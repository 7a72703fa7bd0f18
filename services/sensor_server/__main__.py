"""Run the sensor server: ``python -m services.sensor_server``."""

from bus.service import serve
from robot_model import ports, robot_name
from services.sensor_server.config import SensorServerConfig
from services.sensor_server.service import main

serve(
    main,
    SensorServerConfig,
    name="sensor_server",
    package=__package__,
    clock_port=lambda config: ports.name("clock", robot_name(config.robot)),
)
