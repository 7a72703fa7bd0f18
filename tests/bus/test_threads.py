"""How Zenoh's threads run beside ours."""

import os
import subprocess
import sys

import pytest

from bus.testing import eventually
from tests.bus.messages import Number

POLICIES = """
import os
from pathlib import Path
from bus import Node
from bus.testing import eventually
from tests.bus.messages import Number

with Node("reader", connect=os.environ["HUB"], signals=False) as node:
    inp = node.input("/reader/x:i", Number, source="/writer/x:o", depth=8)
    node.ready()
    eventually(inp.read)
    for task in Path("/proc/self/task").iterdir():
        print((task / "comm").read_text().strip(), os.sched_getscheduler(int(task.name)))
"""


@pytest.fixture
def policies(node) -> set[tuple[str, int]]:
    """Return names and scheduling policies of the threads of a process that reads a stream."""
    out = node.output("/writer/x:o", Number)
    node.ready()
    command, environment = [sys.executable, "-c", POLICIES], {**os.environ, "HUB": node.endpoint}
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as reader:
        eventually(lambda: out.write(Number(value=1.0)) or reader.poll() is not None)
        assert reader.stdout is not None
        lines = reader.stdout.read().splitlines()
    assert reader.returncode == 0
    return {(name, int(policy)) for name, policy in map(str.split, lines)}


def test_zenohs_threads_do_not_preempt_but_for_the_one_that_delivers(policies):
    assert ("tx-0", os.SCHED_BATCH) in policies
    assert {policy for name, policy in policies if name.startswith("python")} == {os.SCHED_OTHER}
    assert os.SCHED_OTHER in {policy for name, policy in policies if name.startswith("rx-")}


def test_no_further_thread_waits_for_the_links(policies):
    assert not {"net-0", "acc-0"} & {name for name, _ in policies}
