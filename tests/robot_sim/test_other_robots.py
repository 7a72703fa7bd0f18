"""Nothing in the plant knows iCub: other joints, other sensors, no feet."""

from pathlib import Path

import numpy as np
import pytest

from robot_model import load_robot
from robot_sim import Plant

DATA = Path(__file__).parents[1] / "robot_model" / "data"


@pytest.fixture(scope="module", params=["arm.yaml", "talos.yaml"])
def other(request):
    return load_robot(DATA / request.param)


def test_another_robot_hangs_on_its_pole_and_feels_a_push(other):
    plant = Plant(other, base="fixed", profile="realistic", seed=1)
    for _ in range(1000):
        plant.step()
    link = other.links[-1]
    plant.push(link, np.zeros(3), np.array([1.0, 2.0, 0.0]), "world")
    plant.step()
    truth, raw = plant.truth(), plant.raw()
    assert truth.support_frames == [other.base_link]
    assert raw.ft.shape == (len(other.ft_sensors), 6) and raw.q.shape == (other.n,)
    assert [push["link"] for push in truth.pushes] == [link]
    friction = other.viscous * truth.dq
    motor = truth.link_torque + other.rotor_inertia @ truth.ddq + friction
    assert truth.motor_torque == pytest.approx(motor, abs=1e-9)


def test_a_robot_without_soles_cannot_stand_free(other):
    with pytest.raises(ValueError, match="no soles to stand on"):
        Plant(other, base="free")
