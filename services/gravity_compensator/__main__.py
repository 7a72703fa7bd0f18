"""Run the gravity compensator: ``python -m services.gravity_compensator``."""

from bus.service import serve
from robot_model import ports, robot_name
from services.gravity_compensator.config import GravityCompensatorConfig
from services.gravity_compensator.service import main

serve(
    main,
    GravityCompensatorConfig,
    name="gravity_compensator",
    package=__package__,
    clock_port=lambda config: ports.name("clock", robot_name(config.robot)),
    never_interrupts=True,
)
