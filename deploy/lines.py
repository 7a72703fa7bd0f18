"""Lines of standard input that come in their own time."""

import os
import select
import sys
from collections.abc import Callable, Iterator

PATIENCE = 0.1  # [s] between two looks at whether to go on


def input_lines(running: Callable[[], bool]) -> Iterator[str]:
    """Yield the lines of standard input, without blank ones, until its end or not ``running()``.

    A plain read would go on after Ctrl-C, which only sets a flag.
    """
    file, rest = sys.stdin.fileno(), b""
    while running():
        if not select.select([file], [], [], PATIENCE)[0]:
            continue
        block = os.read(file, 65536)
        *lines, rest = (rest + block or b"").split(b"\n")
        if not block:
            lines, rest = [rest], b""
        yield from filter(None, (line.decode(errors="replace").strip() for line in lines))
        if not block:
            return
