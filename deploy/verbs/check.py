"""``wrenchbus check``: is everything here, and does everything run?"""

import typer

from deploy.options import Connect, Json, Listen, Namespace, ZenohConfig
from deploy.output import print_json, print_table


def check(
    connect: Connect = None,
    listen: Listen = None,
    config: ZenohConfig = None,
    namespace: Namespace = None,
    as_json: Json = False,
) -> None:
    """Check the installation and the running bus.

    Exit status 1 when a check fails; a warning only limits what works.
    """
    from deploy.doctor.live import live_checks
    from deploy.doctor.machine import machine_checks

    results = [*machine_checks(), *live_checks(connect, listen, config, namespace)]
    rows = [result._asdict() for result in results]
    if as_json:
        print_json(rows)
    else:
        print_table(rows, ["check", "result", "message"])
    raise typer.Exit(1 if any(result.result == "fail" for result in results) else 0)
