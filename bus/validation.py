"""Values checked by a pydantic model, and its complaints in our words."""

from typing import Any

from pydantic import BaseModel, ValidationError

from bus.names import did_you_mean


def validate(model: type[BaseModel], values: Any) -> BaseModel:
    """Return a validated model, or raise ValueError with one line per fault."""
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise ValueError("; ".join(explain(error, model))) from None


def explain(error: ValidationError, model: type[BaseModel]) -> list[str]:
    """Return pydantic's complaints, one line each; unknown keys with what exists."""
    return [_explain(item, model) for item in error.errors(include_url=False)]


def _explain(item: Any, model: type[BaseModel]) -> str:
    key = ".".join(map(str, item["loc"])) or "settings"
    if item["type"] == "extra_forbidden":
        names = list(_flatten_fields(model))
        return f"{key}: unknown key{did_you_mean(key, names)}; there are: {', '.join(names)}"
    return f"{key}: {item['msg']}, got {item['input']!r:.80}"


def _flatten_fields(model: type[BaseModel], prefix: str = "") -> list[str]:
    names = []
    for name, field in model.model_fields.items():
        kind = field.annotation
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            names += _flatten_fields(kind, f"{prefix}{name}.")
        else:
            names.append(prefix + name)
    return names
