"""All inertial sensors together tell the observer more than the head's alone."""

import pytest

from experiments.kinematic_sources import QUANTITIES, run
from robot_model import load_robot

SEED = 70  # no table was made with it


@pytest.fixture(scope="module")
def rms():
    """Return root mean squares by (motion, source, quantity) of one short noisy run."""
    rows = run(load_robot("icub_inertial"), SEED, runs=1, seconds=0.5).figures["rows"]
    return {(row["motion"], row["source"], row["quantity"]): row["rms"] for row in rows}


def test_fusion_beats_the_head_alone_and_more_so_when_the_head_moves(rms):
    motions = list(dict.fromkeys(motion for motion, *_ in rms))
    assert len(motions) == 2
    for motion in motions:
        for quantity in QUANTITIES[:4]:
            head = rms[motion, "head_imu_0", quantity]
            assert 0.0 < rms[motion, "fusion", quantity] < head
    assert rms[motions[1], "fusion", "ft_force"] < 0.5 * rms[motions[1], "head_imu_0", "ft_force"]


def test_a_robot_with_one_inertial_sensor_has_nothing_to_fuse():
    with pytest.raises(ValueError, match="got 1 of icub and 1; try --robot icub_inertial"):
        run(load_robot("icub"), runs=1)
