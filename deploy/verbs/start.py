"""``wrenchbus demo``, ``up``, ``run``: what starts processes."""

import os
import sys
import webbrowser
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from deploy.errors import UsageError
from deploy.options import Connection, Description, Insecure, Seconds, with_connection
from deploy.output import print_line

if TYPE_CHECKING:
    from deploy.launcher.launcher import Launcher


class Base(StrEnum):
    """How the robot stands."""

    free = "free"
    fixed = "fixed"


SPEED_HELP = "Of the simulation to wall time; less than 1 on a machine that is too slow."
MODULES = {"robot_sim": "robot_sim", "dashboard": "dashboard", "hub": "bus.hub"}


def demo(
    seconds: Seconds = None,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Open no page.")] = False,
    robot: Description = "icub",
    scenario: Annotated[str, typer.Option(help="What happens to it, by name or file.")] = "demo",
    profile: Annotated[str, typer.Option(help="Noise of the sensors.")] = "realistic",
    base: Annotated[Base, typer.Option(help="Free on the floor, or fixed on a pole.")] = Base.free,
    speed: Annotated[float, typer.Option(min=0.05, max=10.0, help=SPEED_HELP)] = 1.0,
) -> None:
    """Start the simulated robot and all services, and open the page."""
    from deploy.demo import check_demo, demo_application

    application = demo_application(robot, scenario, profile, base.value, speed, not no_browser)

    def welcome(launcher: "Launcher") -> None:
        tell(launcher)
        if not (no_browser or headless()):
            webbrowser.open(launcher.dashboard_url)

    def check() -> None:
        check_demo(robot, scenario, profile)

    launch(application, "localhost", seconds, welcome, check=check)


def up(
    file: Annotated[str, typer.Argument(help="Application file, or the name of a packaged one.")],
    host: Annotated[str, typer.Option(help="Start the services of this host.")] = "localhost",
    seconds: Seconds = None,
    insecure: Insecure = False,
) -> None:
    """Start the services of an application file and keep them up."""
    from deploy.launcher.application import load_application

    launch(load_application(file), host, seconds, tell, insecure)


@with_connection
def run_service(
    connection: Connection,
    service: Annotated[str, typer.Argument(help="Service, as torque_observer.")],
    name: Annotated[str | None, typer.Option(help="Name on the bus; default: its own.")] = None,
    params: Annotated[str | None, typer.Option(metavar="FILE", help="YAML of settings.")] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="One setting.")
    ] = None,
) -> None:
    """Run one service in the foreground."""
    from bus.child import command

    flags = {"--name": name, "--params": params, "--connect": connection.connect}
    flags |= {"--listen": connection.listen, "--config": connection.config}
    flags |= {"--namespace": connection.namespace}
    arguments = [text for flag, value in flags.items() if value for text in (flag, value)]
    for setting in settings or []:
        arguments += ["--set", setting]
    if connection.insecure:
        arguments.append("--insecure")
    os.execv(sys.executable, command(module_of(service), *arguments, bound=False))


def module_of(service: str) -> str:
    """Return the module of a service.

    Raises:
        UsageError: There is no such service; near names are suggested.
    """
    from pkgutil import iter_modules

    import services
    from bus.names import did_you_mean

    found = {m.name: f"services.{m.name}" for m in iter_modules(services.__path__) if m.ispkg}
    modules = {**MODULES, **found}
    if service not in modules:
        hint = did_you_mean(service, modules)
        raise UsageError(f"no service {service}{hint}; there are: {', '.join(sorted(modules))}")
    return modules[service]


def tell(launcher: "Launcher") -> None:
    """Print what started, where the page is and how to stop."""
    names = ", ".join(process.name for process in launcher.processes)
    print_line(f"running: {names}")
    if launcher.dashboard_url:
        print_line(f"page:    {launcher.dashboard_url}")
    print_line(f"bus:     {launcher.endpoint} (found by wrenchbus list, read, push ...)")
    print_line("stop:    Ctrl-C")


def launch(
    application, host: str, seconds: float | None, on_ready, insecure=False, check=lambda: None
) -> None:
    """Run an application's part of a host; raise UsageError when it has none."""
    from deploy.launcher.launcher import Launcher

    hosts = application.host_names
    if host not in hosts:
        raise UsageError(f"no service for host {host}; the file has {', '.join(sorted(hosts))}")
    namespace = application.hub.namespace
    if namespace is None:
        namespace = f"wrenchbus-{os.getpid()}"
    Launcher(application, namespace, host, on_ready, insecure, check).run(seconds)


def headless() -> bool:
    """Whether there is no screen to open a page on."""
    if not sys.platform.startswith("linux"):
        return False
    return not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
