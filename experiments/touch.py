"""The touch experiment: seeded pushes on a standing robot, and what the detector makes of them.

``python -m experiments.touch --seed 1 --runs 40 --profile realistic``
"""

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from experiments.report import Report
from experiments.touch_pushes import PLACES, PushGenerator
from experiments.touch_run import TouchRun, TouchScore
from robot_model import Robot, load_robot
from robot_sim import Plant

STANDS = 0.2  # rad/s, faster joints after a push: start again from a standing robot


def run(
    robot: Robot,
    seed: int = 1,
    runs: int = 40,
    profile: str = "realistic",
    force: float = 15.0,
    places: str = "surface",
) -> Report:
    """Return how ``run_touches`` went."""
    scores = run_touches(robot, seed, runs, profile, force, places)
    figures = summary(scores)
    said = {"profile": profile, "places": places, "seed": seed}
    listed = {"scores": [asdict(score) for score in scores]}
    return Report("touch", figures | said | listed, lines(figures, scores))


def run_touches(
    robot: Robot,
    seed: int,
    runs: int,
    profile: str = "realistic",
    force: float = 15.0,
    places: str = "surface",
) -> list[TouchScore]:
    """Push a standing robot ``runs`` times and return how each push was seen.

    Args:
        robot: The robot.
        seed: Seed of the pushes and of the sensors' errors.
        runs: Number of pushes.
        profile: Noise profile of the plant.
        force: Force of every push [N].
        places: How places are drawn, see ``PushGenerator``.
    """
    run, scores = TouchRun(robot, profile, seed), []
    for push in islice(PushGenerator(robot, seed, force, places), runs):
        scores.append(run.score(push))
        if not _stands(run.plant):
            run = TouchRun(robot, profile, seed + len(scores))
    return scores


def _stands(plant: Plant) -> bool:
    return not plant.fallen and float(np.abs(plant.truth().dq).max()) < STANDS


def summary(scores: Sequence[TouchScore]) -> dict[str, Any]:
    """Return the figures of a run; points and delays of all pushes, right link or not."""
    points = np.array([score.point_error for score in scores])
    forces = np.array([score.force_error for score in scores])
    delays = np.array([score.delay for score in scores])
    seen = bool(np.isfinite(points).any())
    return {
        "pushes": len(scores),
        "links": len({score.link for score in scores}),
        "subtrees": sorted({score.subtree for score in scores}),
        "detected": float(np.mean([score.detected for score in scores])),
        "flagged_elsewhere": float(np.mean([bool(score.elsewhere) for score in scores])),
        "delay_median": float(np.nanmedian(delays)) if seen else None,
        "first": float(np.mean([score.first for score in scores])),
        "among_three": float(np.mean([score.among_three for score in scores])),
        "point_median": float(np.nanmedian(points)) if seen else None,
        "point_90": float(np.nanpercentile(points, 90)) if seen else None,
        "force_median": float(np.nanmedian(forces)) if seen else None,
    }


def lines(figures: dict[str, Any], scores: Sequence[TouchScore]) -> list[str]:
    """Return the figures as text, with the pushes that were not named right."""
    where = ", ".join(figures["subtrees"])
    text = [
        f"{figures['pushes']} pushes on {figures['links']} links of {where}",
        f"detected {figures['detected']:.0%}, {1e3 * (figures['delay_median'] or 0):.0f} ms after "
        f"5 N (median, sensor delay included); other limbs flagged in "
        f"{figures['flagged_elsewhere']:.0%}",
        f"link right {figures['first']:.1%}, among the first three {figures['among_three']:.1%}",
        f"point {1e3 * (figures['point_median'] or 0):.1f} mm median, "
        f"{1e3 * (figures['point_90'] or 0):.1f} mm in 90 %; "
        f"force {figures['force_median'] or 0:.2f} N median",
    ]
    return text + [
        f"  {score.link} taken for {score.ranking[0] if score.ranking else 'nothing'} "
        f"({score.probability:.2f})"
        for score in scores
        if not score.first
    ]


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m experiments.touch", description=__doc__)
    parser.add_argument("--robot", default="icub", help="name or path of a description")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--runs", type=int, default=40, help="number of pushes")
    parser.add_argument("--profile", default="realistic", help="noise profile of the plant")
    parser.add_argument("--force", type=float, default=15.0, help="force of a push [N]")
    parser.add_argument("--places", choices=PLACES, default="surface")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("-o", "--output", type=Path, help="folder for touch.json")
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> None:
    options = parse(sys.argv[1:] if arguments is None else arguments)
    start = time.monotonic()
    report = run(
        load_robot(options.robot),
        options.seed,
        options.runs,
        options.profile,
        options.force,
        options.places,
    )
    took = {"wall_seconds": time.monotonic() - start}
    report = replace(report, figures=report.figures | took)
    if options.output is not None:
        report.write(options.output)
    print(json.dumps(report.document, indent=1) if options.json else "\n".join(report.lines))


if __name__ == "__main__":
    main()
