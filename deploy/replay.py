"""The application of ``wrenchbus replay``, for one recording."""

from pathlib import Path
from typing import Any

from bus.recording import Recording
from deploy.errors import UsageError
from deploy.launcher.application import Application, load_application
from estimation.differentiation import LEAST
from services.sensor_server.config import FilterConfig

RAW = "/raw:o"
USUAL_DELAY = FilterConfig().delay  # s
BESIDE = ("dashboard", "recorder")  # nobody waits for them


def replay_application(
    file: Path, robot: str | None, support: str, lockstep: bool, replay: dict[str, Any]
) -> Application:
    """Return the packaged application on a recording.

    Args:
        robot: Description, by name or file; None takes the robot that was recorded.
        replay: More settings of the driver: rate, loop, begin, end.

    Raises:
        UsageError: There are no raw frames in it, or those of several robots.
        RecordingError: It is no recording.
    """
    recording = Recording(file)
    port = _raw_port(recording, robot)
    common = {"robot": robot or port.split("/")[1], "support": support}
    settings: dict[str, Any] = {"file": str(file.absolute()), "paused": True, **replay}
    application = load_application("replay").with_common(common)
    if lockstep:
        services = [name for name in application.services if name not in BESIDE]
        settings["participants"] = services
        for name in services:
            application = application.with_params(name, {"lockstep": True})
    rate = recording.ports[port].nominal_hz
    server = {"replay": settings} | (_sampled_at(rate) if rate else {})
    return application.with_params("sensor_server", server)


def _sampled_at(rate: float) -> dict[str, Any]:
    """Settings of the sensor server for frames at a rate [Hz]; slow ones need a longer window."""
    delay = LEAST / rate  # s
    return {"rate": rate} | ({"filter": {"delay": delay}} if delay > USUAL_DELAY else {})


def _raw_port(recording: Recording, robot: str | None) -> str:
    found = [name for name in recording.ports if name.endswith(RAW) and name.count("/") == 2]
    if robot is not None and len(found) > 1:
        found = [name for name in found if name == f"/{robot}{RAW}"] or found
    if len(found) != 1:
        has = ", ".join(found or recording.ports) or "nothing"
        raise UsageError(
            f"{recording.path}: expected the raw frames of one robot (/<robot>{RAW}), it has {has};"
            " wrenchbus play puts any recording on a bus"
        )
    return found[0]
