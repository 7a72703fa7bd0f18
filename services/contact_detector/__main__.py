"""Run the contact detector: ``python -m services.contact_detector``."""

from bus.service import serve
from robot_model import load_robot, ports
from services.contact_detector.config import ContactDetectorConfig
from services.contact_detector.service import main

serve(
    main,
    ContactDetectorConfig,
    name="contact_detector",
    package=__package__,
    clock_port=lambda config: ports.name("clock", load_robot(config.robot)),
    never_interrupts=True,
)
