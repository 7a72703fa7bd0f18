"""Without a truth port nothing that the services compute changes.

Both runs go in lockstep on exact sensors, so that they are the same run. The
feed-forward is cut: whether it reaches the plant one tick earlier or later is chance.
So is what a slow machine makes services say of silence, which is about wall time.
"""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from bus import Node
from robot_model import Robot, messages, ports
from tests.system.stack import MODULES, STREAMS, Stack

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]
TICKS = 200
OF_SILENCE = ("no data on", "nobody writes")
PARTICIPANTS = [name for name in MODULES if name not in ("robot_sim", "dashboard")]
Record = dict[str, dict[int, Any]]  # data and reason by stream and stamp


def settings(truth: bool) -> dict[str, list[str]]:
    """Return the arguments of each service."""
    lockstep = ["--set", "lockstep=true"]
    result = {name: list(lockstep) for name in PARTICIPANTS}
    result["sensor_server"] += ["--set", "inputs={feedforward: /icub/nothing:o}"]
    participants = f"participants=[{', '.join(PARTICIPANTS)}]"
    result["robot_sim"] = [*lockstep, "--set", participants, "--set", "paused=true"]
    result["robot_sim"] += ["--set", f"truth={str(truth).lower()}"]
    return result


def run(robot: Robot, truth: bool) -> Record:
    """Run the robot for some ticks and return everything that was computed."""
    with Stack(robot, settings(truth), without=["dashboard"]) as stack:
        with Node("recorder", connect=stack.endpoint, signals=False) as node:
            keys = (*STREAMS, "truth") if truth else STREAMS
            inputs = {key: _listen(node, robot, key) for key in keys}
            node.ready()
            for _ in range(TICKS // 20):  # each answered in time on the slowest machine
                stack.simulate("step", ticks=20)
            record: Record = {key: {} for key in keys}

            def complete() -> bool:
                for key, port in inputs.items():
                    while (received := port.read()) is not None:
                        envelope = received.envelope
                        if not any(words in envelope.reason for words in OF_SILENCE):
                            record[key][envelope.stamp] = (received.data, envelope.reason)
                return TICKS * 1_000_000 in record["torques"]

            stack.until(complete, lambda: "the last torques do not come")
    return record


def _listen(node: Node, robot: Robot, key: str):
    return node.input(
        f"/recorder/{key}:i",
        getattr(messages, ports.port(key).message),
        source=ports.name(key, robot),
        depth=2 * TICKS,
        model=robot.model_hash,
        dimensions=robot.dimensions,
    )


def difference(ours: Mapping[int, Any], theirs: Mapping[int, Any]) -> float:
    """Return the largest difference of any array at any stamp that both have."""
    largest = 0.0
    for stamp in set(ours) & set(theirs):
        (one, one_reason), (other, other_reason) = ours[stamp], theirs[stamp]
        assert one_reason == other_reason, stamp
        for field in fields(one):
            a, b = getattr(one, field.name), getattr(other, field.name)
            if isinstance(a, np.ndarray) and a.size:
                largest = max(largest, float(np.abs(a.astype(float) - b).max()))
    return largest


def test_no_output_changes_when_the_truth_port_is_absent(robot: Robot):
    with_truth, without = run(robot, True), run(robot, False)
    assert with_truth["truth"]
    for key in STREAMS:
        assert len(set(with_truth[key]) & set(without[key])) > 10, key
        assert difference(with_truth[key], without[key]) == 0.0, key
