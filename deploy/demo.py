"""The application of ``wrenchbus demo``, with what its flags change."""

from deploy.errors import UsageError
from deploy.launcher.application import Application, load_application

SUPPORT = {"free": "floor", "fixed": "pole"}
SLOW_START = 5.0  # s in which a page that is opened at once has the processors


def demo_application(
    robot: str, scenario: str, profile: str, base: str, speed: float = 1.0, page: bool = False
) -> Application:
    """Return the packaged demo for a robot, a scenario, a noise profile, a base and a speed.

    With ``page`` one is opened at once.
    """
    application = load_application("demo").with_common({"robot": robot, "support": SUPPORT[base]})
    plant = {"profile": profile, "base": base, "speed": speed}
    plant |= {"slow_start": SLOW_START} if page else {}
    application = application.with_params("robot_sim", plant)
    return application.with_arguments("scenario", {"name": scenario})


def check_demo(robot: str, scenario: str, profile: str) -> None:
    """Refuse names and files that do not fit, before a slip of the pen starts seven processes.

    Raises:
        UsageError: No such robot, scenario or profile, or a wrong file.
    """
    from robot_model import DescriptionError, load_robot
    from robot_sim.noise import load_profile
    from robot_sim.scenario import load_scenario

    try:
        load_scenario(scenario, load_robot(robot))
        load_profile(profile)
    except (DescriptionError, LookupError, ValueError, OSError) as error:
        raise UsageError(str(error)) from None
