"""Whatever comes from outside is read or refused, and spoils nothing.

A few seconds; ``WRENCHBUS_FUZZ=1000000`` tries that many messages in each test.
"""

import os
from random import Random
from types import SimpleNamespace
from typing import Any

import msgpack
import numpy as np
import pytest
import zenoh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bus import BusError, WireError
from bus.claims import _read
from bus.decoder import Decoder
from bus.encoder import Encoder
from bus.envelope import envelope_of
from bus.packing import pack, unpack
from bus.receivers import Poll
from bus.rpc_server import RpcServer
from bus.tokens import Owner, Token, parse_ready, ready_key
from bus.waiter import Waiter
from bus.wishes import Wishes
from tests.bus.messages import Mixed, Number, Picture, mixed

TRIES = int(os.environ.get("WRENCHBUS_FUZZ", "3000"))
BATCH = 50  # tries for one seed of Hypothesis's
SOURCE = bytes(range(16))
TAGS = (0x00, 0x7F, 0x80, 0x90, 0xA0, 0xC0, 0xC1, 0xC4, 0xC6, 0xC7, 0xCB, 0xCF, 0xD3, 0xDD, 0xDF)

fuzz = settings(
    max_examples=max(TRIES // BATCH, 1),
    deadline=None,
    database=None,
    suppress_health_check=list(HealthCheck),
)
seeds = given(seed=st.integers(0, 2**64 - 1))


def encode(message: Any, seq: int = 1) -> bytes:
    return Encoder(type(message), SOURCE).encode(message, seq, 2, 1, 3, 4)


GOOD = {
    Number: [encode(Number(value=1.5)), encode(Number(value=-2.0), 7)],
    Mixed: [
        encode(mixed(tags=["a", "b"], maps=[{"p": 1.0, "deep": [1, [2]]}], maybe="x")),
        encode(mixed(n=1, k=0, extra=np.zeros(1))),
    ],
    Picture: [encode(Picture(height=2, width=3, pixels=bytes(range(6))))],
}
ALL = [message for messages in GOOD.values() for message in messages]


def spoil(random: Random, data: bytes, others: list[bytes]) -> bytes:
    """Return bytes changed in a few places, or a message with some of its values changed."""
    if random.random() < 0.3:
        return pack_any(change(random, unpack(data)))
    changed = bytearray(data)
    for _ in range(random.randint(1, 4)):
        at = random.randrange(len(changed) + 1)
        kind = random.randrange(6)
        if kind < 3 and at < len(changed):
            changed[at] = random.choice(TAGS) if kind == 0 else random.randrange(256)
        elif kind == 3:
            changed[at:at] = random.randbytes(random.randint(1, 9))
        elif kind == 4:
            del changed[at : at + random.randint(1, 9)]
        else:
            other = random.choice(others)
            start = random.randrange(len(other))
            changed[at : at + 8] = other[start : start + random.randint(1, 16)]
    return bytes(changed)


def change(random: Random, value: Any) -> Any:
    """Return plain values, one of which is another one."""
    if isinstance(value, list) and value and random.random() < 0.9:
        changed = list(value)
        at = random.randrange(len(value))
        changed[at] = change(random, value[at])
        return changed
    if isinstance(value, dict) and value and random.random() < 0.9:
        key = random.choice(list(value))
        return {**value, key: change(random, value[key])}
    return anything(random)


def anything(random: Random, depth: int = 3) -> Any:
    """Return any value that MessagePack knows."""
    several = range(random.randrange(4)) if depth else ()
    return random.choice(
        [
            lambda: None,
            lambda: random.random() < 0.5,
            lambda: random.randint(-(2**63), 2**64 - 1),
            lambda: random.randint(-1, 20),
            lambda: random.choice([0.5, -0.0, 1e308, float("nan"), float("inf")]),
            lambda: random.choice(["", "q", "ft", "Mixed/1", "ä" * 40, "\x00"]),
            lambda: random.randbytes(random.choice([0, 8, 16, 48])),
            lambda: [anything(random, depth - 1) for _ in several],
            lambda: {str(k): anything(random, depth - 1) for k in several},
            lambda: msgpack.ExtType(random.randint(0, 127), b"x"),
            lambda: msgpack.Timestamp(random.randint(0, 2**40), 5),
        ]
    )()


def pack_any(value: Any) -> bytes:
    return bytes(msgpack.packb(value))  # type: ignore[arg-type]


def read(decoder: Decoder, data: bytes) -> tuple[Any, Any] | None:
    try:
        return decoder.decode(data)
    except WireError:
        return None


@fuzz
@seeds
def test_messages_are_read_or_refused_and_the_next_good_one_is_read(seed):
    random = Random(seed)
    kind = random.choice(list(GOOD))
    warm = Decoder(kind)
    for _ in range(BATCH):
        good = random.choice(GOOD[kind])
        rubbish = spoil(random, good, ALL) if random.random() < 0.9 else random.randbytes(99)
        kept = read(warm, good)
        assert kept is not None
        got, expected = read(warm, rubbish), read(Decoder(kind), rubbish)
        assert same(got, expected), rubbish.hex()
        assert got is None or sound(*got), rubbish.hex()
        assert same(read(warm, good), kept), rubbish.hex()


def same(one: tuple | None, other: tuple | None) -> bool:
    """Whether two have been read alike."""
    if one is None or other is None:
        return one is other
    return one[1] == other[1] and encode(one[0]) == encode(other[0])


def sound(data: Any, envelope: Any) -> bool:
    """Whether what was read is what its type declares: then it can be written again."""
    arrays = [value for value in vars(data).values() if isinstance(value, np.ndarray)]
    encode(data)
    return all(np.isfinite(array).all() for array in arrays) and 0 <= envelope.clock <= 1


@fuzz
@seeds
def test_bundles_are_split_into_messages_that_are_read_or_refused(seed):
    random = Random(seed)
    poll: Any = SimpleNamespace(_limit=65536, _bundled=True)
    decoder = Decoder(Number)
    for _ in range(BATCH):
        bundle = pack([random.choice(ALL) for _ in range(random.randint(0, 4))])
        for part in Poll._split(poll, zenoh.ZBytes(spoil(random, bundle, ALL))):
            assert type(part) is int or same(read(decoder, part), read(Decoder(Number), part))


class Question:
    """A query of Zenoh's."""

    key_expr = "server/rpc:i"

    def __init__(self, payload: bytes):
        self.payload = zenoh.ZBytes(payload)
        self.answers: list[bytes] = []

    def reply(self, key: Any, payload: bytes) -> None:
        self.answers.append(payload)

    def reply_err(self, payload: bytes) -> None:
        self.answers.append(payload)

    def drop(self) -> None:
        """The end of the answers."""


@fuzz
@seeds
def test_every_request_gets_one_answer(seed):
    random = Random(seed)
    server = RpcServer(None, "/server/rpc:i", Waiter())  # type: ignore[arg-type]
    server.add("move", lambda link, speed=1.0: {"moved": link})
    requests = [
        pack(["move", {"link": "hand", "speed": 2.0}]),
        pack(["help", {}]),
        pack(["param", {"action": "set", "name": "x", "value": [1, {"y": 2}]}]),
    ]
    for _ in range(BATCH):
        question = Question(spoil(random, random.choice(requests), requests))
        server._handle(question)  # type: ignore[arg-type]
        assert len(question.answers) == 1
        unpack(question.answers[0])


OWNER = Owner("a b/c", "höst", 7, "a1")
TOKEN = Token("/w/x:o", "output", "Mixed/1", 100.0, OWNER, 3, SOURCE, ("/a:o", "/b/c:o"))
KEYS = ["lab/" + TOKEN.key(), TOKEN.key(), ready_key(OWNER)]


@fuzz
@seeds
def test_keys_are_tokens_or_nothing(seed):
    random = Random(seed)
    for _ in range(BATCH):
        key = list(random.choice(KEYS))
        for _ in range(random.randint(0, 3)):
            at = random.randrange(len(key))
            key[at : at + random.randrange(3)] = random.choice(
                ["", "/", "%", "%2", "@wb", "9", "ä"]
            )
        token, owner = Token.parse("".join(key)), parse_ready("".join(key))
        assert token is None or Token.parse(token.key()) == token
        assert owner is None or parse_ready(ready_key(owner)) == owner


@fuzz
@seeds
def test_wishes_are_granted_or_refused(seed):
    random = Random(seed)
    wishes = Wishes()
    good = [
        pack(["set", "/r/x:i", "/w/x:o", True]),
        pack(["forget", "/r/x:i", "/w/x:o"]),
        pack(["of", ["/r/x:i"]]),
    ]
    for _ in range(BATCH):
        try:
            pack(wishes.answer(unpack(spoil(random, random.choice(good), good))))
        except (ValueError, BusError):
            pass


@fuzz
@seeds
def test_envelopes_are_read_or_refused_without_their_data(seed):
    random = Random(seed)
    for _ in range(BATCH):
        rubbish = spoil(random, random.choice(ALL), ALL)
        try:
            envelope_of(rubbish)
        except WireError:
            assert all(read(Decoder(kind), rubbish) is None for kind in GOOD), rubbish.hex()


@pytest.mark.parametrize("good", ALL)
def test_what_is_spoilt_here_was_good(good):
    assert sum(read(Decoder(kind), good) is not None for kind in GOOD) == 1


@fuzz
@seeds
def test_claims_are_read_or_refused(seed):
    random = Random(seed)
    good = pack([TOKEN.key(), TOKEN._replace(epoch=4).key()])
    for _ in range(BATCH):
        question: Any = Question(spoil(random, good, ALL))
        try:
            assert all(isinstance(token, Token) for token in _read(question))
        except ValueError:
            pass
