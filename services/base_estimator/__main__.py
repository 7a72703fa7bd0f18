"""Run the base estimator: ``python -m services.base_estimator``."""

from bus.service import serve
from robot_model import ports, robot_name
from services.base_estimator.config import BaseEstimatorConfig
from services.base_estimator.service import main

serve(
    main,
    BaseEstimatorConfig,
    name="base_estimator",
    package=__package__,
    clock_port=lambda config: ports.name("clock", robot_name(config.robot)),
    never_interrupts=True,
)
