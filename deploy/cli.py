"""The verbs of the ``wrenchbus`` command."""

import typer

from deploy.verbs import (
    calibrate,
    check,
    clock,
    estimate,
    experiment,
    graph,
    latency,
    log_group,
    measure,
    ping,
    play,
    ports,
    presence,
    read,
    record,
    robot,
    rpc,
    service,
    start,
    status,
    top,
    wiring,
    wrench,
    write,
)

app = typer.Typer(
    help="A sense of touch for humanoid robots, as processes on a message bus.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)


def add(verb, name: str, example: str, **settings: bool) -> None:
    """Add a verb; its help ends with the example."""
    app.command(name, epilog=f"Example: wrenchbus {example}", context_settings=settings)(verb)


add(start.demo, "demo", "demo --seconds 60 --no-browser")
add(start.up, "up", "up deploy/apps/demo.yaml --host localhost")
add(service.down, "down", "down")
add(start.run_service, "run", "run torque_observer --set support=pole")
add(status.status, "status", "status --json")
add(service.terminate, "terminate", "terminate torque_observer")
NEGATIVE = {"ignore_unknown_options": True}  # -1 is a value
add(service.param, "param", "param set torque_observer support pole", **NEGATIVE)
app.add_typer(log_group.group, name="log")
add(record.record, "record", "record -o walk.mcap --seconds 60")
add(play.play, "play", "play walk.mcap --rate 0.5 --from 10 --prefix /log")
add(play.replay, "replay", "replay walk.mcap --loop")
add(ping.ping, "ping", "ping torque_observer -n 10")
add(top.top, "top", "top -n 1 --json")
add(ports.list_all, "list", "list --json")
add(ports.info, "info", "info /icub/torques:o")
add(presence.where, "where", "where /icub/torques:o")
add(presence.exists, "exists", "exists /icub/torques:o && echo yes")
add(presence.wait, "wait", "wait /icub/torques:o --timeout 30")
add(read.read, "read", "read /icub/torques:o -n 1 --json")
add(read.read, "echo", "echo /icub/torques:o --envelope")
add(read.sample, "sample", "sample /icub/base:o --json")
add(write.write, "write", "write /toy/in:i value=1.5")
add(measure.hz, "hz", "hz /icub/sensors:o --seconds 5")
add(measure.bw, "bw", "bw /icub/sensors:o")
add(measure.delay, "delay", "delay /icub/torques:o")
add(wiring.connect, "connect", "connect /icub/torques:o /logger/in:i --persist")
add(wiring.disconnect, "disconnect", "disconnect /icub/torques:o /logger/in:i")
add(wiring.connections, "connections", "connections --json")
add(rpc.rpc, "rpc", "rpc /torque_observer/rpc:i param action=list")
add(clock.clock, "clock", "clock step --ticks 10")
add(robot.push, "push", "push l_forearm --force 0,0,-15 --frame world --duration 1")
add(wrench.wrench, "wrench", "wrench joint:l_elbow --frame root_link")
add(robot.tare, "tare", "tare --seconds 1")
add(calibrate.calibrate, "calibrate", "calibrate contacts --seconds 30 --motion reference")
add(robot.stop, "stop", "stop --release")
add(graph.graph, "graph", "graph --robot icub --contact l_forearm -o graph.svg")
add(estimate.estimate, "estimate", "estimate --robot icub walk.mcap -o walk.npz --tare 1")
add(experiment.experiment, "experiment", "experiment ft_prediction --runs 3 -o results")
add(latency.latency_test, "latency-test", "latency-test --size 4096 --rate 1000")
add(check.check, "check", "check --json")
