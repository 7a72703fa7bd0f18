"""The status line: whether what the page shows is live."""

from typing import NamedTuple

from .html import AMBER, GREEN, GREY, RED


class Status(NamedTuple):
    """First word pinned: live, stale, paused or replay."""

    text: str
    colour: str


def status(
    *,
    paused: bool = False,
    frozen: bool = False,
    stale: str = "",
    replay: bool = False,
    time: float | None = None,
    holding: bool = False,
    fallen: bool = False,
) -> Status:
    """Return the status line.

    Args:
        paused: The plant's clock stands still.
        frozen: The page itself stands still, the robot does not.
        stale: Why there are no fresh data; empty when there are.
        replay: The data come from a recording.
        time: Time of the session's clock [s]; None before the first message.
        holding: The robot was stopped and holds its posture.
        fallen: The simulated robot lies on the floor.
    """
    clock = "" if time is None else f"  t = {time:.1f} s"
    if paused:
        return Status(f"paused{clock}", AMBER)
    if frozen:
        return Status("paused (this page only: the robot goes on)", AMBER)
    if stale:
        return Status(f"stale: {stale}", GREY)
    if holding:
        return Status(f"{_word(replay)}{clock}, stopped: holds, refuses commands", RED)
    if fallen:
        return Status(f"{_word(replay)}{clock}, fallen (says the simulator): press Reset", RED)
    return Status(f"{_word(replay)}{clock}", GREEN)


def _word(replay: bool) -> str:
    return "replay" if replay else "live"
