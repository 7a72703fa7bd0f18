"""The description file of a robot: its schema, and where its URDF is."""

import importlib.util
from pathlib import Path
from typing import Annotated, Any

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import ErrorDetails

from robot_model.errors import DescriptionError
from robot_model.names import did_you_mean

DESCRIPTIONS = Path(__file__).parent / "descriptions"
Positive = Annotated[float, Field(gt=0.0)]


class Strict(BaseModel):
    """A part of the file; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class UrdfSource(Strict):
    """Where the URDF is: a path, or a path inside what a Python package installed.

    ``path`` and ``package_dirs`` are relative to the description file; with
    ``package``, to the nearest directory above that package in which ``path`` exists.
    """

    path: str
    package: str | None = None
    package_dirs: list[str] = []  # directories in which package://NAME/ is looked up


class JointRow(Strict):
    """One joint; limits that are left out are those of the URDF."""

    name: str
    part: str
    home: float  # rad
    kp: float = Field(ge=0.0)  # N m/rad
    kd: float = Field(ge=0.0)  # N m s/rad
    rotor: float = Field(ge=0.0)  # kg m^2, seen by the joint
    viscous: float = Field(ge=0.0)  # N m s/rad
    coulomb: float = Field(default=0.0, ge=0.0)  # N m
    position: tuple[float, float] | None = None  # rad
    velocity: float | None = Field(default=None, gt=0.0)  # rad/s
    torque: float | None = Field(default=None, gt=0.0)  # N m


class RotorBlock(Strict):
    """Rotor inertia of joints that share their motors; replaces their ``rotor``."""

    joints: list[str]
    matrix: list[list[float]]  # kg m^2


class ForceTorqueRow(Strict):
    """One force/torque sensor, and the sub-tree on its distal side."""

    name: str
    part: str
    subtree: str
    default_frame: str  # where the sub-tree is touched when nobody knows better
    frame: str | None = None  # the URDF frame of its readings; the sensor's name by default
    joint: str | None = None  # the fixed joint that bears it; from the URDF by default
    range: list[Positive] | None = Field(default=None, min_length=6, max_length=6)  # N, N m


class InertialRange(Strict):
    """Largest readings of an inertial sensor, to both sides, on each axis."""

    gyro: float | None = Field(default=None, gt=0.0)  # rad/s
    acceleration: float | None = Field(default=None, gt=0.0)  # m/s^2


class InertialRow(Strict):
    """One inertial sensor; a bare name is one that measures everything."""

    name: str  # URDF link, frame or inertial <sensor>
    gyro: bool = True
    accelerometer: bool = True
    noise: float = Field(default=1.0, gt=0.0)  # errors relative to the profile's

    @model_validator(mode="before")
    @classmethod
    def _from_name(cls, value: Any) -> Any:
        return {"name": value} if isinstance(value, str) else value


class RootSubtree(Strict):
    """The sub-tree that holds the base link."""

    name: str = "root"
    default_frame: str


class Description(Strict):
    """A robot description file."""

    name: str = Field(pattern=r"^[A-Za-z0-9_.-]+$")
    urdf: UrdfSource
    base_link: str
    joints: list[JointRow] = Field(min_length=1)
    locked_joints: dict[str, float] = {}  # rad; joints of the URDF that are held there
    rotor_blocks: list[RotorBlock] = []
    root_subtree: RootSubtree
    ft_sensors: list[ForceTorqueRow] = []
    imus: list[InertialRow] = []
    imu_ranges: dict[str, InertialRange] = {}
    supports: dict[str, list[str]] = {}
    soles: dict[str, list[tuple[float, float, float]]] = {}  # m, in the support frame
    touchable_links: list[str] = []  # pushed by the touch benchmark; none: all with a surface


def known_robots() -> list[str]:
    """Names of the packaged descriptions."""
    return sorted(path.stem for path in DESCRIPTIONS.glob("*.yaml"))


def description_file(robot: str | Path) -> Path:
    """Return the description file of a packaged robot or of a path to a YAML file."""
    path = Path(robot)
    if path.suffix in (".yaml", ".yml"):
        if not path.is_file():
            raise DescriptionError(str(robot), ["no such description file"])
        return path
    packaged = DESCRIPTIONS / f"{robot}.yaml"
    if str(robot) not in known_robots():
        hint = did_you_mean(str(robot), known_robots())
        raise DescriptionError(str(robot), [f"unknown robot{hint} (or give a path to a .yaml)"])
    return packaged


def read_description(file: Path) -> Description:
    """Read and check a description file's form (not yet against its URDF)."""
    try:
        return Description.model_validate(_content(file))
    except (OSError, yaml.YAMLError) as error:
        raise DescriptionError(str(file), [" ".join(str(error).split())]) from None
    except ValidationError as error:
        raise DescriptionError(str(file), [_describe(item) for item in error.errors()]) from None


def description_text(file: Path) -> str:
    """Return the text of a description that stands by itself, without ``extends``."""
    text = file.read_text()
    return yaml.safe_dump(_content(file)) if "\nextends:" in f"\n{text}" else text


def _content(file: Path) -> Any:
    """Read a file; with ``extends`` its keys replace those of the file named there."""
    content = yaml.load(file.read_text(), getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    if not isinstance(content, dict) or "extends" not in content:
        return content
    base = file.parent / str(content.pop("extends"))
    if base.resolve() == file.resolve():
        raise yaml.YAMLError(f"extends: '{base.name}' is this file itself")
    return {**_content(base), **content}


def _describe(item: ErrorDetails) -> str:
    key = ".".join(map(str, item["loc"])) or "the file"
    if item["type"] == "extra_forbidden":
        return f"{key}: unknown key"
    return f"{key}: {item['msg'].lower()}, got {item['input']!r:.60}"


def find_urdf(source: UrdfSource, file: Path) -> tuple[Path, list[Path]]:
    """Return the URDF's path and the directories in which package:// is looked up."""
    root = file.resolve().parent if source.package is None else _package_root(source, file)
    return root / source.path, [root / directory for directory in source.package_dirs]


def _package_root(source: UrdfSource, file: Path) -> Path:
    spec = importlib.util.find_spec(source.package or "")
    if spec is None or not (spec.submodule_search_locations or spec.origin):
        problem = f"urdf.package: Python package '{source.package}' is not installed"
        raise DescriptionError(str(file), [problem])
    locations = list(spec.submodule_search_locations or []) or [str(spec.origin)]
    package = Path(locations[0]).resolve()
    for root in (package, *package.parents):
        if (root / source.path).is_file():
            return root
    problem = f"urdf.path: no '{source.path}' in or above {package}"
    raise DescriptionError(str(file), [problem])
