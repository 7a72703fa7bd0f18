"""Run the contact detector: ``python -m services.contact_detector``."""

from bus.service import serve
from robot_model import ports, robot_name
from services.contact_detector.config import ContactDetectorConfig
from services.contact_detector.service import main

serve(
    main,
    ContactDetectorConfig,
    name="contact_detector",
    package=__package__,
    clock_port=lambda config: ports.name("clock", robot_name(config.robot)),
    never_interrupts=True,
)
