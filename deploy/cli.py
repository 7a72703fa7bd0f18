"""The verbs of the ``wrenchbus`` command."""

import typer

from deploy.verbs import check, ports, robot, rpc, start, status, stream

app = typer.Typer(
    help="A sense of touch for humanoid robots, as processes on a message bus.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)


def add(verb, name: str, example: str) -> None:
    """Add a verb; its help ends with the example."""
    app.command(name, epilog=f"Example: wrenchbus {example}")(verb)


add(start.demo, "demo", "demo --seconds 60 --no-browser")
add(start.up, "up", "up deploy/apps/demo.yaml --host localhost")
add(start.run_service, "run", "run torque_observer --set support=pole")
add(status.status, "status", "status --json")
add(ports.list_all, "list", "list --json")
add(ports.info, "info", "info /icub/torques:o")
add(stream.read, "read", "read /icub/torques:o -n 1 --json")
add(stream.hz, "hz", "hz /icub/sensors:o --seconds 5")
add(rpc.rpc, "rpc", "rpc /torque_observer/rpc:i param action=list")
add(robot.push, "push", "push l_forearm --force 0,0,-15 --frame world --duration 1")
add(robot.tare, "tare", "tare --seconds 1")
add(robot.stop, "stop", "stop --release")
add(check.check, "check", "check --json")
