"""The list of ports, and the page made from it."""

from pathlib import Path

import pytest

from robot_model import ports
from robot_model.ports_document import message_types, ports_document


def test_names_are_filled_in_for_a_robot(icub):
    assert ports.name("sensors", icub) == "/icub/sensors:o"
    assert ports.name("state", "tiny", part="arm") == "/tiny/arm/state:o"
    assert ports.service_input(icub, "torque_observer", "sensors") == (
        "/icub/torque_observer/sensors:i"
    )
    assert ports.rpc("torque_observer") == "/torque_observer/rpc:i"
    assert ports.sim_rpc(icub) == "/icub/sim/rpc:i"
    assert ports.rate("sensors") == 1000


def test_unknown_ports_are_answered_with_a_near_name():
    with pytest.raises(LookupError, match="no port 'torque'.*did you mean 'torques'"):
        ports.name("torque", "icub")
    with pytest.raises(LookupError, match="takes a part"):
        ports.name("state", "icub")
    with pytest.raises(LookupError, match="takes no part"):
        ports.name("sensors", "icub", part="head")


def test_every_port_carries_a_message_that_exists():
    known = {kind.TYPE.split("/")[0] for kind in message_types()} | {"Clock"}
    assert {port.message for port in ports.PORTS.values()} <= known


def test_names_end_as_their_direction_says():
    for port in ports.PORTS.values():
        assert port.template.endswith(":o" if port.direction == "output" else ":i")


def test_the_page_of_ports_is_current():
    page = Path(__file__).parents[2] / "docs" / "ports.md"
    assert page.read_text() == ports_document(), (
        "run: python -m robot_model.ports_document > docs/ports.md"
    )


def test_the_page_names_every_field_with_its_unit():
    page = ports_document()
    assert "| `motor_torque`? | n | N m |  |" in page
    assert "| `ft_valid` | k flags |  |  |" in page
    for kind in message_types():
        assert f"## {kind.TYPE}\n" in page
