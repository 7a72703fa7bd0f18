"""Metadata with a checksum of their own: MCAP has none for them, and losses are told by them."""

import json
import zlib
from collections.abc import Mapping

from mcap.records import Metadata

SEAL = "crc32"


def seal(name: str, texts: Mapping[str, str]) -> dict[str, str]:
    """Return the texts and their checksum."""
    return {**texts, SEAL: _checksum(name, texts)}


def unseal(record: Metadata) -> dict[str, str]:
    """Return the texts without the checksum; raise ValueError when it does not fit."""
    texts = dict(record.metadata)
    if texts.pop(SEAL, None) != _checksum(record.name, texts):
        raise ValueError(f"checksum of metadata {record.name!r:.60} does not fit")
    return texts


def _checksum(name: str, texts: Mapping[str, str]) -> str:
    return f"{zlib.crc32(json.dumps([name, texts], sort_keys=True).encode()):08x}"
