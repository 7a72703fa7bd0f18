"""Commands on two hosts, and the hub on a third."""

import json

import pytest

from bus.testing import eventually
from tests.multihost.network import network, why_not

pytestmark = pytest.mark.system

JOIN = ("--connect", "tcp/10.0.0.1:7512", "--insecure")
RECORD = ("service=one", "level=info", "logger=here", "text=hello")


def test_what_one_command_writes_another_reads_though_no_hub_passes_it_on(tmp_path):
    if reason := why_not():
        pytest.skip(reason)
    with network(("robot", "one", "two"), tmp_path) as hosts:
        listen = ("--listen", "tcp/10.0.0.1:7512", "--insecure")
        hosts["robot"].start("bus.hub", *listen, "--no-announce", "--settle", "0")
        port = ("/one/said:o", *RECORD, "--type-of", "/hub/log:o", "--rate", "20")
        hosts["one"].run("deploy.main", "wait", "/hub/log:o", *JOIN)
        writing = hosts["one"].start("deploy.main", "write", *port, *JOIN)
        hosts["two"].run("deploy.main", "wait", "/one/said:o", "--timeout", "30", *JOIN)
        read = hosts["two"].run("deploy.main", "sample", "/one/said:o", "--json", *JOIN)
        assert json.loads(read.splitlines()[-1])["data"]["text"] == "hello"
        assert eventually(lambda: "10.0.0.2:0" in writing.output)  # it says that it is reached
