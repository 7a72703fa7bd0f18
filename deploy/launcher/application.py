"""Application files: which services run where, with which settings."""

from pathlib import Path
from typing import Any

import yaml
from pydantic import Field, ValidationError, model_validator

from bus.names import did_you_mean
from deploy.errors import UsageError
from deploy.launcher.parts import Host, HostName, Hub, Part, Request, Service

APPS = Path(__file__).parents[1] / "apps"


class Application(Part):
    """A set of services, of one or several hosts."""

    common: dict[str, Any] = {}  # parameters of every service
    hosts: dict[HostName, Host] = {}  # needed when there are several
    hub: Hub = Hub()
    services: dict[str, Service] = Field(min_length=1)
    once_ready: list[Request] = []

    @model_validator(mode="after")
    def _names_are_free(self) -> "Application":
        taken = {"hub", "launcher"} & self.services.keys()
        if taken:
            raise ValueError(f"service name {sorted(taken)[0]!r} is taken by the launcher's own")
        return self

    @model_validator(mode="after")
    def _hosts_find_each_other(self) -> "Application":
        if len(self.host_names) < 2:
            return self
        if unknown := sorted(self.host_names - self.hosts.keys()):
            known = ", ".join(self.hosts) or "none"
            raise ValueError(
                f"hosts: {unknown[0]!r} has services and is missing; there are: {known}"
            )
        if not self.hub.namespace:
            raise ValueError("hub.namespace: expected a name, the same for all hosts")
        if self.hub.endpoint.endswith(":0"):
            raise ValueError(f"hub.endpoint: expected a certain port, got {self.hub.endpoint}")
        return self

    @property
    def host_names(self) -> set[str]:
        """Hosts on which something runs."""
        return {self.hub.host, *(service.host for service in self.services.values())}

    def listen(self, host: str) -> str:
        """Return where the processes of a host are reached: where its hub is, unless stated."""
        if host in self.hosts:
            return self.hosts[host].listen
        return f"{self.hub.endpoint.rpartition(':')[0]}:0"

    def services_of(self, host: str) -> dict[str, Service]:
        """Return what runs on a host."""
        return {name: spec for name, spec in self.services.items() if spec.host == host}

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
    if detail["type"] == "value_error":  # ours, of the file as a whole
        return detail["msg"].removeprefix("Value error, ")
    key = ".".join(str(part) for part in detail["loc"]) or "file"
    return f"{key}: {detail['msg']}, got {str(detail['input'])[:60]!r}"
