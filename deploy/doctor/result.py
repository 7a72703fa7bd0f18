"""What a check answers."""

from typing import NamedTuple


class Result(NamedTuple):
    """One line of the report; ``result`` is ok, warn or fail, ``message`` says what to do."""

    check: str
    result: str
    message: str


def ok(check: str, message: str) -> Result:
    """Return a check that passed."""
    return Result(check, "ok", message)


def warn(check: str, message: str) -> Result:
    """Return a check that limits what works."""
    return Result(check, "warn", message)


def fail(check: str, message: str) -> Result:
    """Return a check that nothing works without."""
    return Result(check, "fail", message)
