"""The ``wrenchbus`` command: exit status 0 done, 1 failed, 2 wrong usage; never a traceback.

The verbs are imported when Ctrl-C is looked after: that takes a quarter of a second.
"""

import os
import sys

from deploy.one_thread import use_one_thread

INTERRUPTED = 130  # by Ctrl-C, as shells and typer say it


def main() -> None:
    """Run one verb and leave with its exit status."""
    try:
        _open_what_is_closed()
        use_one_thread()
        from deploy.completion import names_rejoined

        with names_rejoined():
            status = run(sys.argv[1:])
    except KeyboardInterrupt:
        status = INTERRUPTED
    sys.exit(status)


def _open_what_is_closed() -> None:
    """Write what would go to a stream that our caller has closed to nobody."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115  # for our life


def run(arguments: list[str]) -> int:
    """Run one verb; return its exit status."""
    import typer

    from deploy.cli import app
    from deploy.errors import CommandError

    try:
        return app(args=arguments, prog_name="wrenchbus", standalone_mode=False) or 0
    except typer.TyperException as error:
        if not arguments:
            print(error.format_message(), file=sys.stderr)  # the help
            return error.exit_code
        return _complain(error.format_message(), error.exit_code)
    except CommandError as error:
        return _complain(str(error), error.exit_code)
    except (KeyboardInterrupt, typer.Abort):
        return INTERRUPTED
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
