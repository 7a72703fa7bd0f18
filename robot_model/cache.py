"""Arrays that are slow to compute, kept on disk between runs."""

import fcntl
import logging
import os
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

Arrays = dict[str, np.ndarray]

log = logging.getLogger(__name__)


def cache_directory() -> Path:
    """Return ``$XDG_CACHE_HOME/wrenchbus``, by default ``~/.cache/wrenchbus``."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "wrenchbus"


def cached(name: str, build: Callable[[], Arrays]) -> Arrays:
    """Return the arrays kept under a name, or build and keep them.

    The name must contain a hash of everything the arrays depend on. A damaged file is
    built again; of several processes that need the same arrays, one builds. Where the
    directory cannot be written, the arrays are built every time.
    """
    file = cache_directory() / f"{name}.npz"
    if (arrays := _read(file)) is not None:
        return arrays
    try:
        with _lock(file):
            if (arrays := _read(file)) is not None:
                return arrays
            arrays = build()
            _write(file, arrays)
            return arrays
    except OSError as error:
        log.warning("cannot keep %s: %s", file, error)
        return build()


def _read(file: Path) -> Arrays | None:
    try:
        # Opened here: NumPy leaves a damaged archive open.
        with file.open("rb") as handle, np.load(handle, allow_pickle=False) as content:
            return dict(content)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        log.warning("%s is damaged and built again: %s", file, error)
        return None


def _write(file: Path, arrays: Arrays) -> None:
    """Write beside the target and rename, so that nobody reads half a file."""
    with tempfile.NamedTemporaryFile(dir=file.parent, suffix=".tmp", delete=False) as part:
        try:
            np.savez(part, allow_pickle=False, **arrays)  # type: ignore[arg-type]
            part.close()
            os.replace(part.name, file)
        except BaseException:
            os.unlink(part.name)
            raise


@contextmanager
def _lock(file: Path) -> Iterator[None]:
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.with_suffix(".lock").open("w") as handle:
        fcntl.flock(handle, fcntl.LOCK_EX)  # released when the file closes, also by a crash
        yield
