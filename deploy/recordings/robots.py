"""The robots of a recording, from the description and the URDF attached to it."""

from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import yaml

from bus.recording import Recording, RecordingWriter
from robot_model import Robot, load_robot
from robot_model.description import UrdfSource, description_text, find_urdf, known_robots
from robot_model.errors import DescriptionError

if TYPE_CHECKING:
    from collections.abc import Mapping

FOLDER = "robot"  # attachments robot/<name>.yaml and robot/<name>.urdf


def attach_robot(writer: RecordingWriter, robot: Robot) -> None:
    """Put a robot's description and URDF beside the messages of a recording."""
    description = description_text(robot.source).encode()
    writer.attach(f"{FOLDER}/{robot.name}.yaml", "application/yaml", description)
    writer.attach(f"{FOLDER}/{robot.name}.urdf", "application/xml", robot.urdf.path.read_bytes())
    writer.note("robot", {"name": robot.name, "model": robot.model_hash})


def robots_of(recording: Recording) -> dict[str, Robot]:
    """Return the robots of a recording by their model hash.

    Those that are attached; without any, the packaged ones that the ports are named after.
    """
    attached = recording.attachments
    files = [name for name in attached if PurePosixPath(name).match(f"{FOLDER}/*.yaml")]
    found = [_rebuilt(attached, name) for name in files]
    robots = [robot for robot in found if robot is not None] or _named(recording)
    return {robot.model_hash: robot for robot in robots}


def _named(recording: Recording) -> list[Robot]:
    first = {name.split("/")[1] for name in recording.ports}
    return [load_robot(name) for name in known_robots() if name in first]


def _rebuilt(attached: "Mapping[str, bytes]", name: str) -> Robot | None:
    """Load an attached robot; None when it does not come with a URDF that fits."""
    stem = PurePosixPath(name).stem
    urdf = attached.get(f"{FOLDER}/{stem}.urdf")
    try:
        content = yaml.safe_load(attached[name])
        directories = _package_dirs(content["urdf"])
    except (yaml.YAMLError, TypeError, KeyError, ValueError):
        return None
    if urdf is None:
        return None
    with TemporaryDirectory() as folder:
        content["urdf"] = {"path": f"{stem}.urdf", "package_dirs": directories}
        (Path(folder) / f"{stem}.urdf").write_bytes(urdf)
        description = Path(folder) / f"{stem}.yaml"
        description.write_text(yaml.safe_dump(content))
        try:
            return load_robot(description)
        except DescriptionError:
            return None


def _package_dirs(source: dict) -> list[str]:
    """Where meshes are on this machine, when the package that bears them is installed."""
    if "package" not in source:
        return []
    try:
        _, directories = find_urdf(UrdfSource.model_validate(source), Path())
    except DescriptionError:
        return []
    return [str(directory) for directory in directories]
