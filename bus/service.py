"""The frame of every service: command line, settings, node, exit status."""

import argparse
import faulthandler
import gc
import logging
import os
import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import zenoh
from pydantic import BaseModel

from bus.configuration import ConfigurationError, load
from bus.errors import BusError
from bus.logs import LEVELS, BusLog, level_of
from bus.node import Node
from bus.parameters import Parameters
from bus.signals import stop_flag
from bus.threads import be_patient

logger = logging.getLogger(__name__)

Main = Callable[[Node, Any], None]
LEAVE_WITHIN = 3.0  # s; usually 0.3 s, and Zenoh has been seen to take more than 5 s
SWITCH_INTERVAL = 1e-3  # s; with Python's 5 ms a busy thread delays the loop by as much


def serve(
    main: Main,
    config: type[BaseModel],
    name: str,
    package: str | None = None,
    clock_port: Callable[[Any], str | None] | str | None = None,
    never_interrupts: bool = False,
) -> NoReturn:
    """Run a service from its command line, and exit.

    Status 0 after SIGTERM, SIGINT or the return of ``main(node, settings)``; 1 when
    the service cannot work, 2 when the command line or the settings are wrong, both
    with one line on standard error (``--log-level debug`` shows where).

    Args:
        main: Opens its ports, calls ``node.ready()``, loops while ``node.running``.
        config: pydantic model of the settings; ``lockstep`` in it turns lockstep on.
        name: The service's name, unless ``--name`` gives another.
        package: Package with the defaults, ``config.yaml``.
        clock_port: Simulated clock to follow, or a function of the settings.
        never_interrupts: Nobody waits for this service; it lets those finish who compute.
    """
    stop_flag.install()  # from here on a signal ends the process with status 0
    gc.freeze()  # what was imported stays: 50 000 objects, which each full round would look at
    options = parser(name, main.__module__).parse_args()
    _prepare(options.log_level)
    if never_interrupts:
        be_patient()
    sys.exit(_status(main, config, package, options, clock_port))


def _status(
    main: Main, config: type[BaseModel], package: str | None, options: Any, clock_port: Any
) -> int:
    try:
        _run(main, load(config, package, options.params, options.set), options, clock_port)
    except ConfigurationError as error:
        return _fail(options.name, error, 2)
    except (BusError, ValueError, LookupError, OSError) as error:
        logger.debug("failed", exc_info=True)
        if not stop_flag.set:
            return _fail(options.name, error, 1)
    return 0


def parser(name: str, module: str = "") -> argparse.ArgumentParser:
    """Return the parser of the options that all services have."""
    program = f"python -m {module.rpartition('.')[0] or module}"
    if module == "__main__":  # a service of one file
        spec = sys.modules["__main__"].__spec__
        program = f"python -m {spec.name}" if spec else f"python {Path(sys.argv[0]).name}"
    result = argparse.ArgumentParser(
        prog=program, epilog=f"example: {program} --set robot=icub --log-level info"
    )
    add = result.add_argument
    add("--name", default=name, help="name of the service on the bus (default: %(default)s)")
    add("--params", metavar="FILE", help="YAML file laid over the default settings")
    add("--set", action="append", metavar="KEY=VALUE", help="one setting; dotted keys; repeatable")
    add("-e", "--connect", metavar="ENDPOINT", help="the hub, as in tcp/127.0.0.1:7512")
    add("-l", "--listen", metavar="ENDPOINT", help="where others reach this process")
    add("-c", "--config", metavar="FILE", help="Zenoh configuration (JSON5)")
    add("--namespace", help="prefix of all keys")
    add("--insecure", action="store_true", help="allow other machines without protection")
    add("--take-over", action="store_true", help="take the names from a process that has them")
    level = {"type": str.lower, "choices": LEVELS, "help": ", ".join(LEVELS)}
    add("--log-level", default="warning", metavar="LEVEL", **level)
    return result


def _prepare(log_level: str) -> None:
    level = level_of(log_level)
    line = "%(levelname)s %(name)s: %(message)s"
    logging.basicConfig(stream=sys.stderr, level=level, format=line)
    for handler in logging.getLogger().handlers:
        handler.setLevel(level)  # the bus hears of more than standard error shows
    zenoh.init_log_from_env_or("error")
    sys.setswitchinterval(SWITCH_INTERVAL)
    faulthandler.register(signal.SIGUSR1)  # kill -USR1 shows where a service hangs


def _run(main: Main, settings: BaseModel, options: argparse.Namespace, clock_port: Any) -> None:
    port: Any = clock_port(settings) if callable(clock_port) else clock_port
    with Node(
        options.name,
        connect=options.connect,
        listen=options.listen,
        namespace=options.namespace,
        zenoh_config=options.config,
        clock_port=port,
        lockstep=bool(getattr(settings, "lockstep", False)),
        insecure=options.insecure,
        take_over=options.take_over,
        parameters=Parameters(settings),
    ) as node:
        BusLog(node)
        node.on_ready.append(_freeze)
        try:
            main(node, settings)
        finally:
            failed = sys.exc_info()[0] is not None and not stop_flag.set
            _end_by_force(int(failed))


def _end_by_force(status: int) -> None:
    """End the process soon, also when the session hangs in closing; its links go with it."""

    def end() -> None:
        logger.error("leaving the bus takes too long; ending without it")
        sys.stderr.flush()
        os._exit(status)

    timer = threading.Timer(LEAVE_WITHIN, end)
    timer.daemon = True
    timer.start()


def _freeze() -> None:
    """Take what start-up has made out of the collector's rounds."""
    gc.collect()
    gc.freeze()


def _fail(name: str, error: Exception, status: int) -> int:
    text = error.args[0] if isinstance(error, KeyError) and error.args else error
    print(f"{name}: {' '.join(str(text).split())}", file=sys.stderr)
    return status
