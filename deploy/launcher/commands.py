"""The command lines of an application's processes."""

import json
from typing import Any

from bus.session import is_local
from bus.wishes import state_directory
from deploy.launcher.application import Application
from deploy.launcher.parts import Service


class Commands:
    """What the processes of one host are started with.

    Args:
        endpoint: The hub's.
        listen: Where the processes of this host are reached.
        insecure: Let them leave the machine without protection.
        lasting: The namespace is used again: the hub keeps what was connected for good.
    """

    def __init__(self, endpoint: str, namespace: str, listen: str, insecure: bool, lasting: bool):
        self._hub = ["--listen", endpoint, "--namespace", namespace]
        if lasting:
            self._hub += ["--state", str(state_directory())]
        self._connection = ["--connect", endpoint, "--namespace", namespace]
        if not is_local(listen):
            self._connection += ["--listen", listen]
        if insecure:
            self._hub.append("--insecure")
            self._connection.append("--insecure")

    def hub(self) -> list[str]:
        """Return module and arguments of the hub."""
        return ["bus.hub", "--no-announce", *self._hub]

    def service(self, name: str, spec: Service, params: dict[str, Any]) -> list[str]:
        """Return module and arguments of a service."""
        settings = [text for item in params.items() for text in ("--set", _setting(*item))]
        return [spec.module, "--name", name, *self._connection, *settings]


def params_of(application: Application, name: str) -> dict[str, Any]:
    """Return the settings of a service."""
    return {**application.common, **application.services[name].params}


def _setting(key: str, value: Any) -> str:
    return f"{key}={json.dumps(value)}"
