"""Settings of the replay driver."""

from pydantic import BaseModel, ConfigDict, Field


class ReplayConfig(BaseModel):
    """Which recording the driver reads, and how."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    file: str = ""
    port: str = ""  # the robot's raw:o when empty
    rate: float = Field(default=1.0, ge=0.01, le=100.0)
    loop: bool = False
    begin: float = Field(default=0.0, ge=0.0)  # s
    end: float | None = Field(default=None, gt=0.0)  # s
    paused: bool = False
    participants: list[str] = []
