"""The plant process: physics, motors and boards, sensors, contacts, scenarios."""

from robot_sim.body import PlantDiverged
from robot_sim.plant import TICK, Plant, PlantConfig

__all__ = ["TICK", "Plant", "PlantConfig", "PlantDiverged"]
