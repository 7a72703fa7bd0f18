"""Runs an import and reads what it wrote."""

import json

import numpy as np

from bus.decoder import Decoder
from bus.recording import Recording
from deploy.main import run
from robot_model.messages import RawFrame
from tests.deploy.yarp_dump import MAP, START

TEXT = MAP.read_text().replace("grid: 1000", "grid: fastest")


def convert(capsys, *arguments):
    """Import and return the summary and what was said on standard error."""
    status = run(["log", *map(str, arguments), "--json"])
    shown = capsys.readouterr()
    assert status == 0, shown.err
    return json.loads(shown.out), shown.err


def frames(path, robot):
    """Return stamps since the first [s] and the raw frames, as a driver would read them."""
    decoder = Decoder(RawFrame, robot.model_hash, robot.dimensions)
    read = [decoder.decode(m.data) for m in Recording(path).messages(["/icub/raw:o"])]
    stamps = np.array([envelope.stamp for _, envelope in read])
    return stamps * 1e-9 - START, [frame for frame, _ in read]


def make_arrays(robot, samples=50):
    return {
        "stamp": 10**9 + 1_000_000 * np.arange(samples),
        "joint_names": np.array(robot.joints[::-1]),
        "q": np.tile(0.01 * np.arange(robot.n)[::-1], (samples, 1)),
        "ft_l_arm_ft": np.ones((samples, 6)),
        "imu_gyro": np.zeros((samples, 3)),
        "imu_acc": np.full((samples, 3), 9.81),
    }
