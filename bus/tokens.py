"""Liveliness tokens: what a port or a service tells everybody about itself."""

import os
import socket
from typing import NamedTuple

from bus.names import from_chunk, to_chunk

PORT, READY = "@wb/port", "@wb/ready"


class Owner(NamedTuple):
    """The process behind a name; ``node`` identifies its session."""

    service: str
    host: str
    pid: int
    node: str

    @classmethod
    def this_process(cls, service: str, node: str) -> "Owner":
        """Return the owner of names that this process opens."""
        return cls(service, socket.gethostname(), os.getpid(), node)

    def __str__(self) -> str:
        return f"{self.service} (host {self.host}, pid {self.pid})"


class Token(NamedTuple):
    """One standing port."""

    name: str
    direction: str  # output, input or rpc
    type: str
    rate: float  # nominal [Hz], 0 when none
    owner: Owner
    epoch: int
    source: bytes
    sources: tuple[str, ...]  # of an input: the names that it reads

    @property
    def rank(self) -> tuple[int, bytes]:
        """Of two that stand on one name, the lower one resigns."""
        return self.epoch, self.source

    def key(self) -> str:
        """Return the key of the liveliness token."""
        texts = (
            *(self.name, self.direction, self.type, f"{self.rate:g}", *map(str, self.owner)),
            *(str(self.epoch), self.source.hex(), ",".join(self.sources)),
        )
        return "/".join((PORT, *map(to_chunk, texts)))

    @classmethod
    def parse(cls, key: str) -> "Token | None":
        """Return the token of a key, or None when the key is not one."""
        chunks = key.split("/")
        try:
            start = chunks.index("@wb") + 2
            texts = [from_chunk(chunk) for chunk in chunks[start:]]
            name, direction, type_, rate, service, host, pid, node, epoch, source, sources = texts
            owner = Owner(service, host, int(pid), node)
            listed = tuple(filter(None, sources.split(",")))
            parsed = cls(
                *(name, direction, type_, float(rate), owner),
                *(int(epoch), bytes.fromhex(source), listed),
            )
        except ValueError:
            return None
        return parsed if chunks[start - 1] == "port" and len(parsed.source) == 16 else None


def ready_key(owner: Owner) -> str:
    """Return the key of a service's readiness token."""
    return "/".join((READY, *(to_chunk(str(text)) for text in owner)))


def parse_ready(key: str) -> Owner | None:
    """Return the owner in a readiness token's key, or None."""
    chunks = key.split("/")
    try:
        start = chunks.index("@wb") + 2
        service, host, pid, node = (from_chunk(chunk) for chunk in chunks[start:])
        return Owner(service, host, int(pid), node) if chunks[start - 1] == "ready" else None
    except ValueError:
        return None
