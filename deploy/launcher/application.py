"""Application files: which services run where, with which settings."""

from pathlib import Path
from typing import Any, Literal

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from bus.names import did_you_mean
from deploy.errors import UsageError

APPS = Path(__file__).parents[1] / "apps"
Restart = Literal["always", "on-failure", "never"]


class Part(BaseModel):
    """Base of everything in an application file: unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Hub(Part):
    """Where processes find each other."""

    host: str = "localhost"
    endpoint: str = Field(default="tcp/127.0.0.1:0", pattern=r"^[a-z]+/.+:\d+$")  # port 0: free
    namespace: str | None = None  # key prefix; None: one of this run's own


class Service(Part):
    """One process of the application."""

    module: str = Field(pattern=r"^[A-Za-z_][\w.]*$")
    host: str = "localhost"
    params: dict[str, Any] = {}
    page_port: str | None = None  # the parameter that receives the port of the web page
    nice: int = Field(default=0, ge=0, le=19)
    realtime: bool = False  # before everything else on its processor, where that is permitted
    restart: Restart = "always"


class Request(Part):
    """An RPC request, sent when every service is ready."""

    port: str = Field(pattern=r"^/.+:i$")
    verb: str
    args: dict[str, Any] = {}
    retry: float = Field(default=0.0, ge=0.0)  # [s] for how long a refusal is asked again
    timeout: float = Field(default=5.0, gt=0.0)  # [s]


class Application(Part):
    """A set of services, of one or several hosts."""

    common: dict[str, Any] = {}  # parameters of every service
    hub: Hub = Hub()
    services: dict[str, Service] = Field(min_length=1)
    once_ready: list[Request] = []

    @model_validator(mode="after")
    def _names_are_free(self) -> "Application":
        taken = {"hub", "launcher"} & self.services.keys()
        if taken:
            raise ValueError(f"service name {sorted(taken)[0]!r} is taken by the launcher's own")
        return self

    def with_params(self, service: str, params: dict[str, Any]) -> "Application":
        """Return a copy in which ``params`` override those of one service."""
        old = self.services[service]
        new = old.model_copy(update={"params": {**old.params, **params}})
        return self.model_copy(update={"services": {**self.services, service: new}})

    def with_common(self, params: dict[str, Any]) -> "Application":
        """Return a copy in which ``params`` override those of every service."""
        return self.model_copy(update={"common": {**self.common, **params}})

    def with_arguments(self, verb: str, args: dict[str, Any]) -> "Application":
        """Return a copy in which the requests of a verb carry other arguments."""
        requests = [
            request.model_copy(update={"args": args}) if request.verb == verb else request
            for request in self.once_ready
        ]
        return self.model_copy(update={"once_ready": requests})


def load_application(name: str) -> Application:
    """Read an application file.

    Args:
        name: Path of a file, or the name of a packaged one (``demo``).

    Raises:
        UsageError: There is no such file, or it is wrong: which key, what was expected.
    """
    path = Path(name)
    if not path.is_file():
        path = _packaged(name)
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        return Application.model_validate(content)
    except ValidationError as error:
        raise UsageError(f"{path}: {_first(error)}") from None
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise UsageError(f"{path}: {' '.join(str(error).split())}") from None


def _packaged(name: str) -> Path:
    path = APPS / f"{name}.yaml"
    if path.is_file() and Path(name).name == name:
        return path
    packaged = sorted(file.stem for file in APPS.glob("*.yaml"))
    hint = did_you_mean(name, packaged)
    raise UsageError(f"no application file {name}{hint}; packaged are: {', '.join(packaged)}")


def _first(error: ValidationError) -> str:
    details = error.errors()
    # a misspelt key is also a missing one; what was written says more
    detail = next((d for d in details if d["type"] == "extra_forbidden"), details[0])
    key = ".".join(str(part) for part in detail["loc"]) or "file"
    return f"{key}: {detail['msg']}, got {str(detail['input'])[:60]!r}"
