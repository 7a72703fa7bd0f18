"""A service's settings: its package's YAML, a file and single keys laid over it, validated."""

from importlib import resources
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from bus.errors import BusError
from bus.validation import explain

Config = TypeVar("Config", bound=BaseModel)
DEFAULTS = "config.yaml"
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # ten times as fast


class ConfigurationError(BusError):
    """A setting is wrong: which file, which key, what was expected, what exists."""


def load(
    model: type[Config],
    package: str | None,
    file: str | Path | None = None,
    settings: list[str] | None = None,
) -> Config:
    """Return the validated settings.

    Args:
        model: Their pydantic model.
        package: Package whose ``config.yaml`` holds the defaults, if there is one.
        file: A YAML file laid over the defaults.
        settings: ``KEY=VALUE`` texts laid over both; dotted keys, values in YAML.
    """
    layers = [_defaults(package)]
    if file is not None:
        layers.append((str(file), _read(Path(file))))
    layers += [_setting(text) for text in settings or ()]
    merged: dict[str, Any] = {}
    for _, values in layers:
        _lay_over(merged, values)
    try:
        return model.model_validate(merged)
    except ValidationError as error:
        complaints = zip(explain(error, model), error.errors(), strict=True)
        lines = [f"{_origin(layers, item['loc'])}: {text}" for text, item in complaints]
        raise ConfigurationError("; ".join(lines)) from None


def _defaults(package: str | None) -> tuple[str, dict[str, Any]]:
    if not package:
        return "defaults", {}
    file = resources.files(package) / DEFAULTS
    if not file.is_file():
        return f"{package} defaults", {}
    return str(file), _parse(file.read_text(), str(file))


def _read(file: Path) -> dict[str, Any]:
    try:
        return _parse(file.read_text(), str(file))
    except OSError as error:
        raise ConfigurationError(f"{file}: {error.strerror}") from None


def _parse(text: str, origin: str) -> dict[str, Any]:
    try:
        values = yaml.load(text, LOADER)
    except yaml.YAMLError as error:
        raise ConfigurationError(f"{origin}: {' '.join(str(error).split())}") from None
    if values is not None and not isinstance(values, dict):
        raise ConfigurationError(f"{origin}: expected KEY: VALUE lines, got {values!r:.60}")
    return values or {}


def _setting(text: str) -> tuple[str, dict[str, Any]]:
    name, sign, value = text.partition("=")
    if not sign or not name:
        raise ConfigurationError(f"--set: expected KEY=VALUE, got {text!r}")
    nested: Any = _scalar(value, text)
    for key in reversed(name.split(".")):
        nested = {key: nested}
    return f"--set {text}", nested


def _scalar(value: str, text: str) -> Any:
    try:
        return yaml.load(value, LOADER)
    except yaml.YAMLError:
        raise ConfigurationError(f"--set: {text!r}: the value is not YAML") from None


def _lay_over(below: dict[str, Any], above: dict[str, Any]) -> None:
    for key, value in above.items():
        if isinstance(value, dict) and isinstance(below.get(key), dict):
            _lay_over(below[key], value)
        else:
            below[key] = value


def _origin(layers: list[tuple[str, dict[str, Any]]], location: tuple) -> str:
    """Return the topmost layer that gives a key."""
    for origin, values in reversed(layers):
        place: Any = values
        for key in location:
            place = place.get(key, _ABSENT) if isinstance(place, dict) else place
        if place is not _ABSENT:
            return origin
    return layers[0][0]


_ABSENT = object()
