"""From a log to a recording: read, check, align, write, and say what was done."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from deploy.errors import CommandError
from deploy.recordings.foreign.csv_table import csv_tracks
from deploy.recordings.foreign.map_file import LogMap, check_names, read_map
from deploy.recordings.foreign.npz_file import npz_tracks
from deploy.recordings.foreign.plausibility import check_plausible
from deploy.recordings.foreign.problems import Problems
from deploy.recordings.foreign.raw_recording import Aligned, align, write_raw
from deploy.recordings.foreign.tracks import Track
from deploy.recordings.foreign.yarp_folder import YarpLog
from robot_model import Robot, load_robot
from services.recorder.about import about

ENOUGH = 200.0  # Hz
TOO_COARSE = (
    "the sensor server's window of 24 ms needs more frames to differentiate positions;"
    " a grid of 1000 Hz gives them"
)

Read = Callable[[LogMap, Robot, Problems], list[Track]]


def import_yarp(folder: Path, map_path: Path, out: Path) -> dict[str, Any]:
    """Make a recording from a folder tree of yarpdatadumper; return the summary."""
    return _import_with_map(folder, map_path, out, YarpLog(folder).tracks)


def import_csv(file: Path, map_path: Path, out: Path) -> dict[str, Any]:
    """Make a recording from a table; return the summary."""
    return _import_with_map(file, map_path, out, lambda *rest: csv_tracks(file, *rest))


def import_npz(file: Path, robot_name: str, grid: float | None, out: Path) -> dict[str, Any]:
    """Make a recording from an npz of arrays, on its own instants or a grid [Hz]."""
    robot, problems = load_robot(robot_name), Problems()
    tracks = npz_tracks(file, robot, problems)
    plain = LogMap.model_construct(
        robot=robot_name, grid=grid or "fastest", gap=5.0, held={}, streams=[]
    )
    return _finish(file, plain, robot, tracks, problems, out)


def _import_with_map(source: Path, map_path: Path, out: Path, read: Read) -> dict[str, Any]:
    log_map, problems = read_map(map_path), Problems()
    robot = load_robot(log_map.robot)
    check_names(log_map, robot, map_path)
    tracks = read(log_map, robot, problems)
    return _finish(source, log_map, robot, tracks, problems, out)


def _finish(
    source: Path,
    log_map: LogMap,
    robot: Robot,
    tracks: list[Track],
    problems: Problems,
    out: Path,
) -> dict[str, Any]:
    check_plausible(tracks, robot, problems)
    aligned = align(tracks, robot, log_map.grid, log_map.gap, log_map.held, problems)
    if aligned.rate < ENOUGH and "ddq" not in aligned.valid:
        problems.warn(f"{aligned.rate:.6g} Hz: {TOO_COARSE}")
    made_of = _made_of(source, log_map, aligned, problems)
    try:
        write_raw(aligned, robot, made_of, out)
    except OSError as error:
        raise CommandError(f"{out}: {error.strerror or error}") from None
    return {
        "file": str(out),
        "frames": len(aligned.stamps),
        "duration_s": float(aligned.stamps[-1] - aligned.stamps[0]) * 1e-9,
        "hz": aligned.rate,
        "lines_left_out": problems.lines,
        "valid": _shares(aligned),
        "report": problems.report(),
    }


def _made_of(source: Path, log_map: LogMap, aligned: Aligned, problems: Problems) -> dict[str, str]:
    """What the file says of its own making."""
    grid = log_map.grid if log_map.grid == "fastest" else f"{log_map.grid:g} Hz"
    return about() | {
        "source": source.name,
        "robot": log_map.robot,
        "interpolation": f"linear; gaps of more than {log_map.gap:g} periods are invalid",
        "grid": f"{grid} ({aligned.rate:.6g} Hz)",
        "force_torque": json.dumps(_conventions(log_map)),
        "held_rad": json.dumps(log_map.held),
        "lines_left_out": str(problems.lines),
        "report": "\n".join(problems.report()),
    }


def _conventions(log_map: LogMap) -> dict[str, Any]:
    stated = [stream.ft for stream in log_map.streams if stream.ft is not None]
    return {ft.sensor: ft.model_dump()["convention"] for ft in stated}


def _shares(aligned: Aligned) -> dict[str, float]:
    """Return the part of the instants at which any channel of a kind was valid."""
    return {kind: float(np.mean(flags.any(axis=1))) for kind, flags in aligned.valid.items()}
