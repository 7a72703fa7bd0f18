"""Names of ports and what is made of them."""

import pytest

from bus import BusError
from bus.envelope import new_source
from bus.names import check_name, did_you_mean, from_chunk, key_of, near_names, to_chunk
from bus.tokens import Owner, Token, parse_ready, ready_key


@pytest.mark.parametrize("name", ["/icub/sensors:o", "/a", "/a.b-c_d/e:i", "/robot1/left_arm/ft:o"])
def test_a_good_name_becomes_its_key(name):
    assert key_of(name) == name[1:]


@pytest.mark.parametrize(
    "name",
    ["", "/", "icub/x:o", "/a/", "//a", "/a//b", "/a b", "/a*", "/a#", "/a?", "/ä", "/@wb/x"],
)
def test_a_bad_name_is_refused(name):
    with pytest.raises(BusError, match="bad port name"):
        check_name(name)


@pytest.mark.parametrize(
    ("name", "direction"), [("/a:i", "output"), ("/a:o", "input"), ("/a", "rpc")]
)
def test_the_suffix_says_the_direction(name, direction):
    with pytest.raises(BusError, match="ends in :"):
        check_name(name, direction)


@pytest.mark.parametrize("text", ["", "%", "/a/b:o", "a b", "ä#?$*", "x" * 50])
def test_any_text_is_one_chunk(text):
    chunk = to_chunk(text)
    assert chunk and "/" not in chunk and from_chunk(chunk) == text


def test_near_names_are_offered():
    names = ["/icub/sensors:o", "/icub/torques:o", "/icub/base:o"]
    assert near_names("/icub/sensor:o", names)[0] == "/icub/sensors:o"
    assert did_you_mean("/icub/torque:o", names).startswith(" (did you mean /icub/torques:o")
    assert did_you_mean("zzz", names) == ""


def test_a_token_tells_everything_about_a_port():
    owner = Owner("torque_observer", "my host", 42, "abc")
    token = Token("/a/b:i", "input", "Mixed/1", 250.0, owner, 3, new_source(), ("/x:o", "/y:o"))
    assert Token.parse(token.key()) == token
    assert Token.parse("some/namespace/" + token.key()) == token
    assert parse_ready(ready_key(owner)) == owner


@pytest.mark.parametrize(
    "key", ["", "a/b", "@wb/port", "@wb/port/a/b/c", "@wb/ready/a", "@wb/port" + 11 * "/x"]
)
def test_a_key_that_is_no_token_is_ignored(key):
    assert Token.parse(key) is None
    assert parse_ready(key) is None
