"""``wrenchbus latency-test``: round trips between two processes."""

from typing import Annotated, Any

import typer

from deploy.options import Connection, Json, with_connection
from deploy.output import print_json, print_line, print_table

LARGEST = 4_000_000  # bytes; a link carries 4 MiB


@with_connection
def latency_test(
    connection: Connection,
    size: Annotated[
        int, typer.Option(min=8, max=LARGEST, help="Bytes of payload, in steps of 8.")
    ] = 512,
    rate: Annotated[float, typer.Option(min=0.1, max=10000.0, help="Round trips [Hz].")] = 500.0,
    seconds: Annotated[float, typer.Option(min=0.1, help="How long to measure each.")] = 3.0,
    as_json: Json = False,
) -> None:
    """Measure round trips through the bus and through Zenoh alone, between two processes.

    On the bus that runs, or on one that is started for it. Both are taken over from Zenoh's
    thread by one of Python's, as services do.
    """
    from deploy.latency.measurement import measure
    from deploy.session import any_bus

    with any_bus(connection) as node:
        result = measure(node, size, rate, seconds)
    if as_json:
        print_json(result)
        return
    print_line(
        f"round trips of {result['size']} bytes"
        f" ({result['message_bytes']} with the envelope) at {rate:g} Hz"
    )
    columns = ["over", "p50 [us]", "p99 [us]", "p99.9 [us]", "max [us]", "count", "lost"]
    print_table([_row(name, result[name]) for name in ("bus", "zenoh")], columns)


def _row(name: str, summary: dict[str, Any]) -> dict[str, Any]:
    row = {"over": name, "count": summary["count"], "lost": summary["lost"]}
    for key, label in (("p50", "p50"), ("p99", "p99"), ("p99_9", "p99.9"), ("max", "max")):
        value = summary[key]
        row[f"{label} [us]"] = None if value is None else f"{1e6 * value:.0f}"
    return row
