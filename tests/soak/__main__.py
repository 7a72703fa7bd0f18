"""Run it: something happens every few seconds; afterwards everything must be well again.

Exit status 1 when something did not recover, when an old message was taken for a fresh one,
when messages between the two that were left alone were lost, or when somebody grows.
"""

import argparse
import json
import logging
import sys
import time
from collections import Counter
from random import Random
from typing import Any

from bus import BusError
from tests.soak.gauges import Gauges
from tests.soak.stage import STEADY, Stage

LOSSES = 0.01  # share of the messages between the two that are left alone
TOLD = 60.0  # s between two lines of progress


def main() -> int:
    """Run the command."""
    parser = argparse.ArgumentParser(prog="python -m tests.soak", description=__doc__)
    parser.add_argument("--hours", type=float, default=1.0)
    parser.add_argument("--pairs", type=int, default=3, help="writers and readers")
    parser.add_argument("--pause", type=float, default=2.0, help="s between two incidents, mean")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--too-old", type=float, default=1.0, help="s; more than 0.1, as the machine may be busy"
    )
    options = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    figures, complaints = soak(options)
    print(json.dumps(figures, indent=1))
    for complaint in complaints:
        print(f"soak: {complaint}", file=sys.stderr)
    return int(bool(complaints))


def soak(options: argparse.Namespace) -> tuple[dict[str, Any], list[str]]:
    """Return figures, and what was not as it should be."""
    random, gauges, incidents = Random(options.seed), Gauges(), Counter()
    stage, recoveries, complaints = Stage(options.pairs, random), [], []
    told, end = time.monotonic(), time.monotonic() + 3600.0 * options.hours
    try:
        stage.recovered()
        before = stage.report(STEADY[1], clear=True)
        while time.monotonic() < end:
            incidents[stage.act()] += 1
            recoveries.append(stage.recovered())
            complaints += _old_news(stage, options.too_old)
            for name, process in stage.processes.items():
                gauges.look(name, process.pid)
            _rest(stage, random.expovariate(1.0 / options.pause))
            if time.monotonic() > told + TOLD:
                told = time.monotonic()
                print(f"{end - told:.0f} s to go, {dict(incidents)}", file=sys.stderr, flush=True)
        after = stage.report(STEADY[1])
    except (AssertionError, BusError) as error:
        complaints.append(str(error))
        before = after = None
    complaints += stage.close() + gauges.complaints()
    figures = {
        "incidents": dict(incidents),
        "requests_unanswered": dict(stage.unanswered),
        "recovery_s": {"median": _quantile(recoveries, 0.5), "worst": _quantile(recoveries, 1.0)},
        "processes": gauges.report(),
        "left_alone": _flow(before, after),
    }
    if figures["left_alone"]["lost"] > LOSSES * figures["left_alone"]["received"]:
        complaints.append(f"losses between those left alone: {figures['left_alone']}")
    return figures, complaints


def _rest(stage: Stage, seconds: float) -> None:
    end = time.monotonic() + seconds
    while (remaining := end - time.monotonic()) > 0.0:
        stage.node.wait(remaining)


def _old_news(stage: Stage, too_old: float) -> list[str]:
    """Return which readers took old messages for fresh ones since the last time."""
    reports = {sink: stage.report(sink, clear=True) for sink in stage.sinks}
    return [
        f"{sink} took a message of {report['oldest_fresh']:.2f} s for a fresh one"
        for sink, report in reports.items()
        if report is not None and report["oldest_fresh"] > too_old
    ]


def _flow(before: dict[str, Any] | None, after: dict[str, Any] | None) -> dict[str, int]:
    if before is None or after is None:
        return {"received": 0, "lost": 0}
    return {
        key: after["statistics"][key] - before["statistics"][key] for key in after["statistics"]
    }


def _quantile(values: list[float], share: float) -> float:
    ordered = sorted(values)
    return round(ordered[min(int(share * len(ordered)), len(ordered) - 1)], 3) if ordered else 0.0


if __name__ == "__main__":
    sys.exit(main())
