"""The file into which a service writes the settings that were changed."""

from pathlib import Path
from typing import Any

from bus.parameters import Parameters, dump
from bus.wishes import state_directory

_ABSENT = object()


def save_settings(service: str, parameters: Parameters) -> dict[str, str]:
    """Write ``changes`` into a file that ``--params`` reads; return its path."""
    import yaml

    file = saved_file(service)
    file.parent.mkdir(parents=True, exist_ok=True)
    text = yaml.safe_dump(changes(parameters), sort_keys=False)
    file.write_text(text, encoding="utf-8")
    return {"file": str(file), "message": f"saved in {file}; wrenchbus run {service} --params FILE"}


def saved_file(service: str) -> Path:
    """Return ``$XDG_STATE_HOME/wrenchbus/settings/<service>.yaml``."""
    return state_directory().with_name("settings") / f"{service.replace('/', '.')}.yaml"


def changes(parameters: Parameters) -> dict[str, Any]:
    """Return, nested as in the file, what differs from the start or from the model's defaults."""
    if parameters.value is None:
        return {}
    others = (parameters.started, type(parameters.value).model_construct())
    return _unlike(dump(parameters.value), list(map(dump, others)))


def _unlike(values: dict[str, Any], others: list[dict[str, Any]]) -> dict[str, Any]:
    found = {}
    for key, value in values.items():
        theirs = [other.get(key, _ABSENT) for other in others]
        if value and all(isinstance(one, dict) for one in (value, *theirs)):
            if nested := _unlike(value, theirs):
                found[key] = nested
        elif any(one != value for one in theirs):
            found[key] = value
    return found
