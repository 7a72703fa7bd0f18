"""``latency-test``: round trips between two processes."""

import json

from deploy.main import run


def test_latency_test_compares_the_bus_with_zenoh_alone_without_a_bus_running(
    runtime_directory, capsys
):
    words = ["latency-test", "--size", "64", "--rate", "200", "--seconds", "0.5", "--json"]
    assert run(words) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["size"] == 64 and 100 < result["message_bytes"] < 250
    for over in ("bus", "zenoh"):
        summary = result[over]
        assert summary["count"] == 100 and summary["lost"] < 50
        assert 0.0 < summary["p50"] <= summary["p99"] <= summary["p99_9"] <= summary["max"]
    assert not list(runtime_directory.glob("*")), "its own hub is not announced to others"
