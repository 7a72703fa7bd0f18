"""Connections that are wished for good: kept by the hub, told to whoever opens the input."""

import json
import logging
import os
from pathlib import Path
from typing import Any

import zenoh
from zenoh.handlers import Callback

from bus.errors import BusError
from bus.names import check_name
from bus.packing import pack, unpack

logger = logging.getLogger(__name__)

WISHES = "@wb/hub/wishes"
MOST = 4096  # inputs and sources; more is a mistake of somebody's
MOST_NAMESPACES = 256
LONGEST = 255  # characters of a name that is kept
MAX_REQUEST = 1 << 20  # bytes

Wanted = dict[str, bool]  # source to whether it is read


class Wishes:
    """What third parties asked to persist: ``{input: {output: connected}}``.

    Args:
        path: Where it is kept over a restart of the hub; None keeps it in memory only.
    """

    def __init__(self, path: Path | None = None):
        self._wishes: dict[str, Wanted] = {}
        self._path: Path | None = None
        if path is not None and self._load(path):
            self._path = path

    def answer(self, request: Any) -> Any:
        """Answer ``["all"]``, ``["of", [input, ...]]``, ``["set", input, output, connected]`` or
        ``["forget", input, output]``; raise ValueError for anything else."""
        match request:
            case ["all"]:
                return self._wishes
            case ["of", list() as sinks]:
                return {s: self._wishes[s] for s in map(str, sinks) if s in self._wishes}
            case ["set", str() as sink, str() as source, bool() as wanted]:
                return self._set(check_name(sink, "input"), check_name(source, "output"), wanted)
            case ["forget", str() as sink, str() as source]:
                self._wishes.get(sink, {}).pop(source, None)
                return self._keep()
        raise ValueError(f"expected all, of, set or forget, got {request!r:.100}")

    def _load(self, path: Path) -> bool:
        """Return whether the file may be written over: it was read, or there is none."""
        try:
            for sink, wanted in json.loads(path.read_text()).items():
                for source, connected in wanted.items():
                    self.answer(["set", sink, source, connected])
        except FileNotFoundError:
            pass
        except (OSError, ValueError, AttributeError, BusError) as error:
            logger.error("%s is unreadable and left alone: %s", path, error)
            return False
        return True

    def _set(self, sink: str, source: str, wanted: bool) -> None:
        if max(len(sink), len(source)) > LONGEST:
            raise ValueError(f"a name of more than {LONGEST} characters is not kept")
        if sum(map(len, self._wishes.values())) >= MOST:
            raise ValueError(f"{MOST} connections are wished already")
        self._wishes.setdefault(sink, {})[source] = wanted
        self._keep()

    def _keep(self) -> None:
        self._wishes = {sink: wanted for sink, wanted in self._wishes.items() if wanted}
        if self._path is not None:
            _write(self._path, self._wishes)


class WishServer:
    """Answers for all namespaces; each has wishes of its own."""

    def __init__(self, session: zenoh.Session, directory: Path | None = None):
        self._directory = directory
        self._wishes: dict[str, Wishes] = {}
        self._queryable = session.declare_queryable(
            f"**/{WISHES}", Callback(self._answer, indirect=False)
        )

    def close(self) -> None:
        """Answer no more."""
        self._queryable.undeclare()

    def _answer(self, query: zenoh.Query) -> None:
        try:
            payload = query.payload
            if payload is None or len(payload) > MAX_REQUEST:
                raise ValueError(f"expected a request of at most {MAX_REQUEST} bytes")
            wishes = self._of(str(query.key_expr).partition("@wb")[0])
            answer = wishes.answer(unpack(payload.to_bytes()))
            query.reply(query.key_expr, pack(answer))
        except (ValueError, OSError, BusError) as error:
            query.reply_err(pack({"error": str(error)}))

    def _of(self, namespace: str) -> Wishes:
        if namespace not in self._wishes:
            if len(self._wishes) >= MOST_NAMESPACES:
                raise ValueError(f"{MOST_NAMESPACES} namespaces have wishes already")
            name = namespace.strip("/").replace("/", ".") or "default"
            path = self._directory / f"{name}.json" if self._directory is not None else None
            self._wishes[namespace] = Wishes(path)
        return self._wishes[namespace]


def state_directory() -> Path:
    """Return where a hub keeps wishes: ``$XDG_STATE_HOME/wrenchbus/wishes``."""
    home = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(home) / "wrenchbus" / "wishes"


def _write(path: Path, wishes: dict[str, Wanted]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = path.with_suffix(".new")
    fresh.write_text(json.dumps(wishes, indent=1))
    fresh.replace(path)  # whole or not at all
