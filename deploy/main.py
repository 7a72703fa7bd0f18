"""The ``wrenchbus`` command: exit status 0 done, 1 failed, 2 wrong usage; never a traceback."""

import sys

import typer

from deploy.cli import app
from deploy.completion import names_rejoined
from deploy.errors import CommandError

INTERRUPTED = 130  # what typer returns when Ctrl-C ended a verb


def main() -> None:
    """Run one verb and leave with its exit status."""
    with names_rejoined():
        sys.exit(run(sys.argv[1:]))


def run(arguments: list[str]) -> int:
    """Run one verb; return its exit status."""
    try:
        code = app(args=arguments, prog_name="wrenchbus", standalone_mode=False)
        return 1 if code == INTERRUPTED else code or 0
    except typer.TyperException as error:
        return _complain(error.format_message(), error.exit_code)
    except CommandError as error:
        return _complain(str(error), error.exit_code)
    except (KeyboardInterrupt, typer.Abort):
        return 1
    except Exception as error:
        if not _is_bus_error(error):
            raise
        return _complain(str(error), 1)


def _complain(message: str, code: int) -> int:
    print(f"wrenchbus: {' '.join(message.split())}", file=sys.stderr)
    return code


def _is_bus_error(error: Exception) -> bool:
    """Whether it is one of the bus's; the wire is loaded then, and only then."""
    bus = sys.modules.get("bus")
    return bus is not None and isinstance(error, bus.BusError)


if __name__ == "__main__":
    main()
