"""The parts of an application file."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

ENDPOINT = r"^[a-z]+/.+:\d+$"
HostName = Annotated[str, Field(pattern=r"^[A-Za-z0-9_.-]+$")]  # becomes a part of port names
Restart = Literal["always", "on-failure", "never"]


class Part(BaseModel):
    """Base of everything in an application file: unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Host(Part):
    """One machine."""

    listen: str = Field(pattern=ENDPOINT)  # where its processes are reached; port 0: each its own


class Hub(Part):
    """Where processes find each other."""

    host: HostName = "localhost"
    endpoint: str = Field(default="tcp/127.0.0.1:0", pattern=ENDPOINT)  # port 0: free
    namespace: str | None = None  # key prefix; None: one of this run's own


class Service(Part):
    """One process of the application."""

    module: str = Field(pattern=r"^[A-Za-z_][\w.]*$")
    host: HostName = "localhost"
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
