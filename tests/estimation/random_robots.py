"""Robots for tests: any tree of links and joints, and iCub with other sensors."""

import json
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from robot_model import Robot, load_robot
from robot_model.description import DESCRIPTIONS

Row = Mapping[str, Any]


def described_robot(directory: Path, joints: Sequence[Row], imus: Sequence[str]) -> Robot:
    """Return a robot of links "link0", "link1", ...; joints as ``random_joints`` makes them.

    A joint of type "sensor" is a fixed joint with a force/torque sensor "ft<child>".
    """
    count = 1 + max(max(joint["parent"], joint["child"]) for joint in joints)
    rng = np.random.default_rng(count)
    sensors = [row for row in joints if row["type"] == "sensor"]
    parts = [*(_link(i, rng) for i in range(count)), *map(_joint, joints), *map(_sensor, sensors)]
    urdf = directory / "robot.urdf"
    urdf.write_text('<robot name="random">' + "".join(parts) + "</robot>")
    file = directory / "robot.yaml"
    file.write_text(json.dumps(_description(joints, list(imus))))
    return load_robot(file)


def random_joints(rng: np.random.Generator, count: int, sensors: float) -> list[dict[str, Any]]:
    """Return rows of a random tree with ``count`` joints, a share of them sensors."""
    kinds = rng.choice(
        ["revolute", "prismatic", "fixed", "sensor"],
        count,
        p=[0.6 * (1 - sensors), 0.25 * (1 - sensors), 0.15 * (1 - sensors), sensors],
    )
    kinds[0] = "revolute"
    return [
        {
            "type": str(kind),
            "child": child,
            "parent": int(rng.integers(max(0, child - 4), child)),
            "xyz": rng.uniform(-0.3, 0.3, 3),
            "rpy": rng.uniform(-3.0, 3.0, 3),
            "axis": rng.normal(size=3),
        }
        for child, kind in enumerate(kinds, start=1)
    ]


def limbed_robot(directory: Path, joints: int, sensors: int) -> Robot:
    """Return a robot with one limb per sensor, the sensor beyond the limb's first joint."""
    rng, rows = np.random.default_rng(joints), []
    for limb in range(sensors):
        length = joints // sensors + (limb < joints % sensors)
        parent = 0
        for kind in ["revolute", "sensor", *["revolute"] * (length - 1)]:
            place = {"xyz": rng.uniform(-0.2, 0.2, 3), "rpy": rng.uniform(-3.0, 3.0, 3)}
            child = len(rows) + 1
            rows.append({"type": kind, "child": child, "parent": parent, **place})
            rows[-1]["axis"] = rng.normal(size=3)
            parent = child
    return described_robot(directory, rows, ["link0"])


def _text(vector: Sequence[float]) -> str:
    return " ".join(f"{x:.17g}" for x in vector)


def _link(index: int, rng: np.random.Generator) -> str:
    factor = rng.normal(size=(3, 3))
    points = factor @ factor.T  # second moments of a body that exists
    moments = 0.01 * (np.trace(points) * np.eye(3) - points)
    ixx, iyy, izz = np.diag(moments)
    return (
        f'<link name="link{index}"><inertial>'
        f'<origin xyz="{_text(rng.uniform(-0.1, 0.1, 3))}"/>'
        f'<mass value="{rng.uniform(0.1, 5.0):.17g}"/>'
        f'<inertia ixx="{ixx:.17g}" iyy="{iyy:.17g}" izz="{izz:.17g}" ixy="{moments[0, 1]:.17g}"'
        f' ixz="{moments[0, 2]:.17g}" iyz="{moments[1, 2]:.17g}"/></inertial></link>'
    )


def _joint(row: Row) -> str:
    kind = "fixed" if row["type"] == "sensor" else row["type"]
    return (
        f'<joint name="joint{row["child"]}" type="{kind}">'
        f'<origin xyz="{_text(row["xyz"])}" rpy="{_text(row["rpy"])}"/>'
        f'<parent link="link{row["parent"]}"/><child link="link{row["child"]}"/>'
        f'<axis xyz="{_text(row["axis"])}"/>'
        '<limit lower="-2" upper="2" velocity="5" effort="100"/></joint>'
    )


def _sensor(row: Row) -> str:
    return (
        f'<sensor name="ft{row["child"]}" type="force_torque">'
        f'<parent joint="joint{row["child"]}"/><force_torque><frame>child</frame>'
        "<measure_direction>child_to_parent</measure_direction></force_torque>"
        '<origin xyz="0 0 0" rpy="0 0 0"/></sensor>'
    )


def _description(joints: Sequence[Row], imus: list[str]) -> dict[str, Any]:
    moving = [row for row in joints if row["type"] in ("revolute", "prismatic")]
    drive = {"part": "all", "home": 0, "kp": 10, "kd": 1, "rotor": 0.1, "viscous": 0.1}
    sensors = [row["child"] for row in joints if row["type"] == "sensor"]
    return {
        "name": "random",
        "urdf": {"path": "robot.urdf"},
        "base_link": "link0",
        # The order is not the URDF's.
        "joints": [{"name": f"joint{row['child']}", **drive} for row in reversed(moving)],
        "root_subtree": {"default_frame": "link0"},
        "ft_sensors": [
            {
                "name": f"ft{child}",
                "part": "all",
                "subtree": f"beyond{child}",
                "default_frame": f"link{child}",
                "frame": f"link{child}",
                "joint": f"joint{child}",
            }
            for child in sensors
        ],
        "imus": imus,
    }


def icub_with(directory: Path, sensors: Sequence[str]) -> Robot:
    """Return iCub with some of its force/torque sensors."""
    description = yaml.safe_load((DESCRIPTIONS / "icub.yaml").read_text())
    rows = description["ft_sensors"]
    description["ft_sensors"] = [row for row in rows if row["name"] in sensors]
    file = directory / f"icub_{len(sensors)}.yaml"
    file.write_text(yaml.safe_dump(description))
    return load_robot(file)


def small_icub(directory: Path) -> Robot:
    """Return iCub with neck and wrists locked and no sensors in its feet: n = 23, k = 4.

    The URDF is a copy without the feet's sensor elements, which the peer would use.
    """
    description = yaml.safe_load((DESCRIPTIONS / "icub.yaml").read_text())
    locked = {
        r["name"] for r in description["joints"] if "neck" in r["name"] or "wrist" in r["name"]
    }
    description["joints"] = [row for row in description["joints"] if row["name"] not in locked]
    description["locked_joints"] = dict.fromkeys(locked, 0.0)
    feet = {row["name"] for row in description["ft_sensors"] if "foot" in row["name"]}
    description["ft_sensors"] = [r for r in description["ft_sensors"] if r["name"] not in feet]
    tree = ElementTree.parse(load_robot("icub").urdf.path)
    for element in tree.getroot().findall("sensor"):
        if element.get("name") in feet:
            tree.getroot().remove(element)
    tree.write(directory / "model.urdf")
    description["urdf"] = {"path": "model.urdf"}
    file = directory / "icub_23.yaml"
    file.write_text(yaml.safe_dump(description))
    return load_robot(file)
