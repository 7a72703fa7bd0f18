"""``wrenchbus log``: verbs on recordings, and without one of them what the services log."""

from collections.abc import Callable
from typing import Any

import typer
from typer.core import TyperGroup

from deploy.verbs import log, log_repair, recordings

SERVICES = "services"  # what `wrenchbus log` does when it is not told


class LogGroup(TyperGroup):
    """Takes what is none of its verbs as arguments of ``services``."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put ``services`` before arguments that begin with no verb."""
        if not args or (args[0] not in self.commands and args[0] not in ctx.help_option_names):
            args = [SERVICES, *args]
        return super().parse_args(ctx, args)


group = typer.Typer(
    cls=LogGroup,
    help="Show what services log (log [SERVICE], options: log services -h); read recordings.",
    epilog="Example: wrenchbus log torque_observer --level warning --follow",
)


def _add(verb: Callable[..., None], name: str, example: str) -> None:
    group.command(name, epilog=f"Example: wrenchbus log {example}")(verb)


_add(log.log, SERVICES, "torque_observer --level warning --follow")
_add(recordings.info, "info", "info touch.mcap --json")
_add(recordings.export, "export", "export touch.mcap /icub/torques:o -o touch.npz")
_add(recordings.convert, "convert", "convert touch.mcap --json -o touch_json.mcap")
_add(recordings.diff, "diff", "diff live.mcap replayed.mcap")
_add(log_repair.repair, "repair", "repair cut.mcap -o whole.mcap")
_add(recordings.import_yarp, "import-yarp", "import-yarp dump --map icub.yaml -o dump.mcap")
_add(recordings.import_csv, "import-csv", "import-csv log.csv --map log.yaml -o log.mcap")
_add(recordings.import_npz, "import-npz", "import-npz log.npz --robot icub -o log.mcap")
