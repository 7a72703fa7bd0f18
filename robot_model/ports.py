"""The one list of ports: name, message, rate and writer.

Health, the command line, the page and the documents read it; there is no second list.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from robot_model.names import did_you_mean

if TYPE_CHECKING:
    from robot_model.robot import Robot


@dataclass(frozen=True)
class Port:
    """A port of a robot; ``template`` holds <robot> and, for views, <part>."""

    template: str
    message: str  # name of the message type
    rate: float  # nominal Hz; 0 when it is written now and then
    owner: str  # the service that opens it
    description: str
    direction: Literal["output", "input"] = "output"


def _in(template: str, message: str, rate: float, owner: str, description: str) -> Port:
    return Port(template, message, rate, owner, description, "input")


PORTS: dict[str, Port] = {
    "raw": Port("/<robot>/raw:o", "RawFrame", 1000, "robot_sim", "what the driver delivers"),
    "clock": Port("/<robot>/clock:o", "Clock", 20, "robot_sim", "simulated time and its state"),
    "truth": Port("/<robot>/truth:o", "GroundTruth", 250, "robot_sim", "what the plant knows"),
    "sensors": Port(
        "/<robot>/sensors:o", "SensorFrame", 1000, "sensor_server", "all channels of one instant"
    ),
    "state": Port(
        "/<robot>/<part>/state:o", "PartState", 1000, "sensor_server", "joints of one part"
    ),
    "ft": Port(
        "/<robot>/<part>/ft:o", "PartForceTorque", 1000, "sensor_server", "sensors of one part"
    ),
    "inertial": Port("/<robot>/inertial:o", "Inertial", 1000, "sensor_server", "inertial sensors"),
    "motor_command": Port(
        "/<robot>/motor_command:o", "MotorCommand", 200, "sensor_server", "what the boards do"
    ),
    "base": Port(
        "/<robot>/base:o", "BaseState", 250, "base_estimator", "pose and velocity of the base"
    ),
    "torques": Port("/<robot>/torques:o", "JointTorques", 1000, "torque_observer", "link torques"),
    "wrenches": Port(
        "/<robot>/wrenches:o", "ExternalWrenches", 1000, "torque_observer", "external wrenches"
    ),
    "ft_prediction": Port(
        "/<robot>/ft_prediction:o", "FtPrediction", 1000, "torque_observer", "F/T without contacts"
    ),
    "gravity": Port(
        "/<robot>/gravity:o", "GravityTorques", 100, "gravity_compensator", "hold against gravity"
    ),
    "residuals": Port(
        "/<robot>/residuals:o", "Residuals", 250, "contact_detector", "momentum residuals"
    ),
    "contacts": Port(
        "/<robot>/contacts:o", "Contacts", 250, "contact_detector", "where the robot is touched"
    ),
    "contact_map": Port(
        "/<robot>/contact_map:o", "ContactMap", 20, "contact_detector", "touches over the surface"
    ),
    "touch_points": Port(
        "/<robot>/touch_points:o", "ContactPoints", 20, "contact_detector", "places of the touches"
    ),
    "contact_points": _in(
        "/<robot>/contact_points:i", "ContactPoints", 0, "torque_observer", "where wrenches act now"
    ),
    "virtual_torque": _in(
        "/<robot>/virtual_torque:i", "JointTorques", 1000, "sensor_server", "link torques"
    ),
    "feedforward": _in(
        "/<robot>/feedforward:i", "GravityTorques", 100, "sensor_server", "torques for the boards"
    ),
    "command": _in(
        "/<robot>/command:i", "JointCommand", 0, "sensor_server", "position, velocity or torque"
    ),
    "robot_sim_motor_command": _in(
        "/<robot>/robot_sim/motor_command:i", "MotorCommand", 200, "robot_sim", "for the boards"
    ),
}


def port(key: str) -> Port:
    """Return an entry of the list, or raise LookupError with what exists."""
    if key not in PORTS:
        raise LookupError(f"no port '{key}' in the list{did_you_mean(key, PORTS)}")
    return PORTS[key]


def name(key: str, robot: "Robot | str", part: str = "") -> str:
    """Return a port's name, such as ``/icub/sensors:o`` or ``/icub/head/state:o``."""
    template = port(key).template
    if ("<part>" in template) != bool(part):
        needed = "a part" if "<part>" in template else "no part"
        raise LookupError(f"port '{key}' takes {needed}, got '{part}'")
    return template.replace("<robot>", _robot_name(robot)).replace("<part>", part)


def rate(key: str) -> float:
    """Return a port's nominal rate, Hz; 0 when it is written now and then."""
    return port(key).rate


def service_input(robot: "Robot | str", service: str, what: str) -> str:
    """Return the default name of a service's input, ``/<robot>/<service>/<what>:i``."""
    return f"/{_robot_name(robot)}/{service}/{what}:i"


def rpc(service: str) -> str:
    """Return a service's RPC port, ``/<service>/rpc:i``."""
    return f"/{service}/rpc:i"


def sim_rpc(robot: "Robot | str") -> str:
    """Return the plant's RPC port, ``/<robot>/sim/rpc:i``."""
    return f"/{_robot_name(robot)}/sim/rpc:i"


def _robot_name(robot: "Robot | str") -> str:
    return robot if isinstance(robot, str) else robot.name
