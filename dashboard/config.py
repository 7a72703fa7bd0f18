"""Settings of the page."""

from ipaddress import ip_address

from pydantic import Field, field_validator

from robot_model.service_config import RobotServiceConfig

Vector3 = tuple[float, float, float]


class DashboardConfig(RobotServiceConfig):
    """Where the page is served, how often it changes and what is drawn how large."""

    host: str = "127.0.0.1"
    port: int = Field(default=0, ge=0, le=65535)  # 0: any free one
    trusted_origins: list[str] = []  # of a proxy in front, e.g. https://robot.example
    replay: bool = False  # the data come from a recording
    inputs: dict[str, str] = {}  # source ports that differ from the robot's own
    makes_room: bool = False  # a simulation slows down while a browser loads the page

    scene_rate: float = Field(default=25.0, gt=0.0, le=60.0)  # [Hz]
    idle_rate: float = Field(default=1.0, gt=0.0)  # [Hz] while nobody looks
    chart_rate: float = Field(default=10.0, gt=0.0)  # [Hz]
    map_rate: float = Field(default=5.0, gt=0.0)  # [Hz]
    alarm_rate: float = Field(default=5.0, gt=0.0)  # [Hz]
    text_rate: float = Field(default=2.0, gt=0.0)  # [Hz]
    watch_period: float = Field(default=1.0, gt=0.0)  # [s] between looks at the ports

    touch_scale: float = Field(default=0.01, gt=0.0)  # [m/N]
    support_scale: float = Field(default=0.001, gt=0.0)  # [m/N]
    hide_below: float = Field(default=2.0, ge=0.0)  # [N]
    chart_seconds: float = Field(default=12.0, gt=0.0)  # [s]
    chart_points: int = Field(default=300, ge=2, le=300)

    push_force: float = Field(default=15.0, gt=0.0)  # [N]
    push_limit: float = Field(default=60.0, gt=0.0)  # [N]
    push_duration: float = Field(default=1.5, gt=0.0)  # [s]
    tare_seconds: float = Field(default=1.0, gt=0.0)  # [s]

    camera_offset: Vector3 = (1.5, -0.9, 0.45)  # [m] from the base, along the world's axes
    camera_look_at: Vector3 = (0.0, 0.0, 0.0)  # [m] likewise

    @field_validator("host")
    @classmethod
    def _is_loopback(cls, host: str) -> str:
        if host != "localhost" and not ip_address(host).is_loopback:
            raise ValueError(
                f"expected a loopback address such as 127.0.0.1, got {host}: the page has no"
                " password; publish it through a proxy that asks for one"
            )
        return host
