"""How Zenoh's threads run beside ours."""

import os
import subprocess
import sys

import pytest

from bus.testing import eventually
from tests.bus.messages import Number

READER = """
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
        print((task / "comm").read_text().strip())
"""


@pytest.fixture
def threads(node) -> set[str]:
    """Return the names of the threads of a process that reads a stream."""
    out = node.output("/writer/x:o", Number)
    node.ready()
    command, environment = [sys.executable, "-c", READER], {**os.environ, "HUB": node.endpoint}
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as reader:
        eventually(lambda: out.write(Number(value=1.0)) or reader.poll() is not None)
        assert reader.stdout is not None
        lines = reader.stdout.read().splitlines()
    assert reader.returncode == 0
    return set(lines)


def test_one_thread_of_zenohs_waits_for_the_links_and_reads_them(threads):
    assert "rx-0" in threads
    assert not {"net-0", "acc-0"} & threads


def test_a_loop_that_nobody_waits_for_is_never_preferred():
    code = "import os, bus.threads as t; t.be_patient(); print(os.sched_getscheduler(0))"
    printed = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True).stdout
    assert int(printed) == os.SCHED_BATCH
