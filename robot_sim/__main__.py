"""Run the plant: ``python -m robot_sim``."""

from bus.service import serve
from robot_sim.config import SimConfig
from robot_sim.service import main

serve(main, SimConfig, name="robot_sim", package=__package__)
