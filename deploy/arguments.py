"""``KEY=VALUE`` on the command line."""

import re
from typing import Any

import yaml

from deploy.errors import UsageError

_EXPONENT = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+")  # which YAML 1.1 takes for a text


def arguments(pairs: list[str]) -> dict[str, Any]:
    """Read ``key=value`` pairs; values are YAML: ``3``, ``true``, ``[0, 0, 1]``, ``text``."""
    values = {}
    for pair in pairs:
        key, equals, text = pair.partition("=")
        if not equals or not key:
            raise UsageError(f"expected KEY=VALUE such as seconds=1.0, got {pair!r}")
        values[key] = value(text, key)
    return values


def value(text: str, name: str) -> Any:
    """Read one value in YAML."""
    if _EXPONENT.fullmatch(text):
        return float(text)
    if not text:
        return ""
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError:
        raise UsageError(f"the value of {name} is not YAML: {text!r}") from None
