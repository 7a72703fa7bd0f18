"""A service's live settings: listed, read and set over RPC, validated by their pydantic model."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from bus.names import did_you_mean

if TYPE_CHECKING:
    from pydantic import BaseModel

Listener = Callable[[Any, Any], None]


class Parameters:
    """``value`` is a frozen pydantic model, replaced as a whole by every change; None: no settings.

    ``started`` is what it was at the start, by the service's configuration.
    """

    def __init__(self, value: "BaseModel | None" = None):
        self.value: Any = value
        self.started = self.value
        self._listeners: list[Listener] = []

    def on_change(self, listener: Listener) -> None:
        """Call ``listener(old, new)`` in the main thread; an exception of it undoes the change."""
        self._listeners.append(listener)

    def names(self) -> list[str]:
        """Return the dotted names of all settings."""
        return list(_flatten(dump(self.value)))

    def get(self, name: str) -> Any:
        """Return one setting (or a group of them) by its dotted name."""
        return self._get(self.value, name)

    def _get(self, settings: "BaseModel | None", name: str) -> Any:
        value: Any = dump(settings)
        for key in name.split("."):
            if not isinstance(value, dict) or key not in value:
                raise LookupError(self._unknown(name))
            value = value[key]
        return value

    def set(self, name: str, value: Any) -> Any:
        """Set one setting; return it as validated, or raise ValueError with pydantic's reason."""
        from bus.validation import validate

        self.get(name)
        changed = self.value.model_dump()
        *path, last = name.split(".")
        place = changed
        for key in path:
            place = place[key]
        place[last] = value
        self.replace(validate(type(self.value), changed))
        return self.get(name)

    def replace(self, new: "BaseModel") -> None:
        """Put a whole new value in force."""
        old, self.value = self.value, new
        try:
            for listener in self._listeners:
                listener(old, new)
        except Exception:
            self.value = old
            raise

    def reset(self, name: str) -> Any:
        """Set one setting (or a group of them) to what it was at the start; return that."""
        return self.set(name, self._get(self.started, name))

    def handle(self, action: str, name: str = "", value: Any = None) -> Any:
        """Answer the verb ``param``: ``list``, ``get``, ``set`` or ``reset``."""
        if action == "list":
            return _flatten(dump(self.value))
        if action == "get":
            return self.get(name)
        if action == "set":
            return self.set(name, value)
        if action == "reset":
            return self.reset(name)
        raise ValueError(f"param: expected action list, get, set, reset or save, got {action!r}")

    def _unknown(self, name: str) -> str:
        names = self.names()
        listed = ", ".join(names) or "none"
        return f"unknown parameter {name!r}{did_you_mean(name, names)}; there are: {listed}"


def dump(settings: "BaseModel | None") -> dict[str, Any]:
    """Return settings as JSON has them."""
    return {} if settings is None else settings.model_dump(mode="json")


def _flatten(values: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in values.items():
        if isinstance(value, dict) and value:
            flat |= _flatten(value, f"{prefix}{key}.")
        else:
            flat[prefix + key] = value
    return flat
