"""The forger of the system tests, against the real decoder: its right messages are right."""

import pytest

from bus.clock import Clock
from bus.decoder import Decoder
from bus.errors import WireError
from bus.schema import fields_of
from robot_model import messages
from tests.system.forgery import bad_messages, message

DIMENSIONS = {"n": 32, "k": 6, "m": 1}
TYPES = [Clock, *(t for t in vars(messages).values() if hasattr(t, "TYPE"))]


def info_of(message_type: type) -> dict:
    fields = [field.describe() for field in fields_of(message_type)]
    return {"type": message_type.TYPE, "fields": fields}  # type: ignore[attr-defined]


@pytest.mark.parametrize("message_type", TYPES, ids=lambda t: t.__name__)
def test_a_right_message_is_accepted_and_every_bad_one_refused(message_type: type):
    info = info_of(message_type)
    decoder = Decoder(message_type, "6b2b7b79", DIMENSIONS)
    decoder.decode(message(info, DIMENSIONS, "6b2b7b79"))
    bad = bad_messages(info, DIMENSIONS, "6b2b7b79")
    assert len(bad) >= 7
    for name, payload in bad.items():
        if name != "an oversized message":  # refused by its size, before it is decoded
            with pytest.raises(WireError):
                decoder.decode(payload)
                pytest.fail(f"{name} was accepted")
