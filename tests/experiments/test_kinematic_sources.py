"""All inertial sensors together tell the observer more than the head's alone."""

import json

import pytest

from experiments.kinematic_sources import QUANTITIES, main

SEED = 70  # no table was made with it


@pytest.fixture(scope="module")
def rms(tmp_path_factory):
    """Return root mean squares by (motion, source, quantity) of one short noisy run."""
    folder = tmp_path_factory.mktemp("table")
    main(["--seed", str(SEED), "--runs", "1", "--seconds", "0.5", "-o", str(folder)])
    rows = json.loads((folder / "kinematic_sources.json").read_text())["rows"]
    return {(row["motion"], row["source"], row["quantity"]): row["rms"] for row in rows}


def test_fusion_beats_the_head_alone_and_more_so_when_the_head_moves(rms):
    motions = list(dict.fromkeys(motion for motion, *_ in rms))
    assert len(motions) == 2
    for motion in motions:
        for quantity in QUANTITIES[:4]:
            head = rms[motion, "head_imu_0", quantity]
            assert 0.0 < rms[motion, "fusion", quantity] < head
    assert rms[motions[1], "fusion", "ft_force"] < 0.5 * rms[motions[1], "head_imu_0", "ft_force"]
