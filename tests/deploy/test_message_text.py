"""Text that becomes messages."""

import numpy as np
import pytest

from bus.decoder import Decoder
from bus.encoder import Encoder
from bus.schema import fields_of
from deploy.errors import UsageError
from deploy.message_text import Composer, read_fields
from tests.bus.messages import Mixed

GIVEN = {"q": [1, 2, 3], "ft": [[0, 0, 0, 0, 0, 1.5]], "ok": [True, False, True]}
REST = {
    "name": "leg",
    "count": 2,
    "delay": 1,
    "on": False,
    "tags": ["a"],
    "maps": [],
    "maybe": None,
}


@pytest.fixture
def composer():
    """Composer of messages that are described as a port describes them."""
    return Composer("Mixed/1", [field.describe() for field in fields_of(Mixed)])


def test_words_are_read_as_yaml():
    words = ["a=1", "b=[1, 2]", "c=true", "d=text", "e=1e-3", "f="]
    expected = {"a": 1, "b": [1, 2], "c": True, "d": "text", "e": 1e-3, "f": ""}
    assert read_fields(words) == expected


def test_a_line_may_hold_words_with_quotes_or_json():
    assert read_fields(["a=1 b='x y'"]) == {"a": 1, "b": "x y"}
    assert read_fields([' {"a": [1], "b": "x"}\n']) == {"a": [1], "b": "x"}


@pytest.mark.parametrize("text", ["a", "=1", '{"a": ', "a='", "a=[1"])
def test_what_is_neither_is_refused_and_shown(text):
    with pytest.raises(UsageError, match="expected KEY=VALUE|bad JSON|not YAML"):
        read_fields([text])


def test_lists_become_arrays_of_the_declared_kind(composer):
    message = composer.compose(GIVEN | REST)
    assert message.q.dtype == np.float64 and message.q.tolist() == [1.0, 2.0, 3.0]
    assert message.ft.shape == (1, 6)
    assert message.ok.dtype == bool and message.ok.tolist() == [True, False, True]
    assert message.extra is None and message.name == "leg"


def test_a_message_as_read_prints_it_can_be_written_again(composer):
    line = {"port": "/x:o", "envelope": {}, "data": GIVEN | REST | {"extra": None}}
    assert composer.compose(line).q.tolist() == [1.0, 2.0, 3.0]


def test_what_is_left_out_is_left_to_the_reader_and_its_defaults(composer):
    encoded = Encoder(composer.type, bytes(16)).encode(composer.compose(GIVEN), 1, 0, 0, 0, 0)
    message, _ = Decoder(Mixed).decode(encoded)
    assert (message.name, message.count, message.on, message.tags) == ("arm", 3, True, [])
    assert message.extra is None


def test_an_empty_list_is_an_empty_array_of_any_shape(composer):
    message = composer.compose(GIVEN | {"q": [], "ft": [], "ok": []})
    assert message.ft.shape == (0, 6) and message.q.shape == (0,)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"qq": 1}, r"Mixed/1 has no field qq.*its fields are: q \(float64\[n\] N m\)"),
        ({"q": "abc"}, r"field q: expected numbers shaped \(n\), got 'abc'"),
        ({"q": [[1], [2, 3]]}, "field q: expected numbers"),
        ({"q": [True]}, "field q: expected numbers"),
        ({"ok": [1, 0, 1]}, "field ok: expected booleans"),
    ],
)
def test_a_wrong_field_is_named_with_what_is_expected(composer, change, expected):
    with pytest.raises(UsageError, match=expected):
        composer.compose(GIVEN | REST | change)


def test_a_missing_field_is_named(composer):
    with pytest.raises(UsageError, match="field ft: missing"):
        composer.compose({"q": [1.0], "ok": [True]} | REST)
