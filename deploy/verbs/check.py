"""``wrenchbus check``: is everything here, and does everything run?"""

import typer

from deploy.options import Connection, Json, with_connection
from deploy.output import print_json, print_table


@with_connection
def check(connection: Connection, as_json: Json = False) -> None:
    """Check the installation and the running bus.

    Exit status 1 when a check fails; a warning only limits what works.
    """
    from deploy.doctor.live import live_checks
    from deploy.doctor.machine import machine_checks

    results = [*machine_checks(), *live_checks(connection)]
    rows = [result._asdict() for result in results]
    if as_json:
        print_json(rows)
    else:
        print_table(rows, ["check", "result", "message"])
    raise typer.Exit(1 if any(result.result == "fail" for result in results) else 0)
