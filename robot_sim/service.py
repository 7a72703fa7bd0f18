"""The plant process."""

from bus import BusError, Node
from robot_model import load_robot
from robot_sim.body import PlantDiverged
from robot_sim.config import SimConfig
from robot_sim.simulation import Simulation
from robot_sim.verbs import Verbs


def main(node: Node, config: SimConfig) -> None:
    """Simulate one robot until asked to stop."""
    simulation = Simulation(node, load_robot(config.robot), config)
    Verbs(node, config, simulation)
    node.ready()
    try:
        simulation.run()
    except PlantDiverged as error:
        raise BusError(str(error)) from error
