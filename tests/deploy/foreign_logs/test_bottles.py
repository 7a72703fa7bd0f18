"""The text that YARP writes, one bottle per line."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from deploy.recordings.foreign.bottle import BottleError, parse

BOTTLES = [
    ("1 -2.5 +3 1e-3 .5", [1, -2.5, 3, 1e-3, 0.5]),
    ("(1 2 (3)) [ok] 4", [[1, 2, [3]], "ok", 4]),
    ('"a b" c "say \\"hi\\"" "" "line\\nend"', ["a b", "c", 'say "hi"', "", "line\nend"]),
    ("0x1f 0X10 -0x1", [31, 16, -1]),
    ("true false null", [True, False, None]),
    ("{0 255 16}", [b"\x00\xff\x10"]),
    ("1, 2,3", [1, 2, 3]),
    ("left-arm 1.2.3 e5 in", ["left-arm", "1.2.3", "e5", "in"]),
    ("()", [[]]),
    ("", []),
]


@pytest.mark.parametrize(("text", "expected"), BOTTLES)
def test_a_bottle_is_read_as_yarp_writes_it(text, expected):
    assert parse(text) == expected


@pytest.mark.parametrize("text", ["(1 2", "1)", '"open', "[ok", "{300}", "(" * 100])
def test_a_bottle_that_does_not_close_is_an_error(text):
    with pytest.raises(BottleError):
        parse(text)


@given(st.text(alphabet='01.-+xeinf(){}[]"\\ ,a\n', max_size=60))
def test_any_text_is_a_bottle_or_an_error(text):
    try:
        parse(text)
    except BottleError:
        pass
