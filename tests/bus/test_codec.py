"""Messages to bytes and back."""

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from bus import WireError
from bus.decoder import Decoder
from bus.encoder import Encoder
from bus.packing import pack, unpack
from tests.bus.messages import Mixed, Number, array, mixed

SOURCE = bytes(range(16))
DIMENSIONS = {"n": 3, "k": 2}

# docs/wire.md shows the same bytes; another language can be tested against them
NUMBER_HEX = (
    "9ea84e756d6265722f31c410000102030405060708090a0b0c0d0e0fce00000002cf0000000000000007d300"
    "0000000000000901d3000000000000000ad3000000000000000bc3a0a081a576616c7565cb3ff80000000000"
    "0090c400"
)
MIXED_HEX = (
    "9ea74d697865642f31c410000102030405060708090a0b0c0d0e0fce00000000cf0000000000000001d30000"
    "00000000000200d30000000000000003d30000000000000004c2a56e6f206674a8613938376636313088a26f"
    "6b92c3c2a46e616d65a361726da5636f756e7403a564656c6179cb3fd0000000000000a26f6ec2a474616773"
    "91a178a46d6170739181a166cb3ff0000000000000a56d61796265c09292a1710293a266740106c440000000"
    "0000000000000000000000f03f0000000000000000000000000000f03f000000000000004000000000000008"
    "4000000000000010400000000000001440"
)


def encoder(message_type=Mixed, model="", dimensions=None, epoch=0):
    return Encoder(message_type, SOURCE, epoch, model, dimensions)


def encode(message, **more):
    arguments = {"seq": 1, "stamp": 2, "clock": 0, "acquired": 3, "sent": 4, **more}
    return encoder(type(message)).encode(message, **arguments)


def repack(data, position, value):
    parts = unpack(data)
    parts[position] = value
    return pack(parts)


def assert_equal(left, right):
    for item in dataclasses.fields(left):
        a, b = getattr(left, item.name), getattr(right, item.name)
        assert type(a) is type(b), item.name
        assert np.array_equal(a, b) if isinstance(a, np.ndarray) else a == b, item.name


def test_a_message_comes_back_as_it_was():
    message = mixed(tags=["a", "b"], maps=[{"links": ["x"], "p": 0.5, "deep": [[1.0], [2.0]]}])
    decoded, envelope = Decoder(Mixed).decode(encode(message, valid=False, reason="no data"))
    assert_equal(decoded, message)
    assert envelope == ("Mixed/1", SOURCE, 0, 1, 2, 0, 3, 4, False, "no data", "")


def test_the_repeated_form_decodes_like_the_first():
    writer, reader = encoder(), Decoder(Mixed)
    for seq in range(1, 6):
        message = mixed(q=np.full(3, float(seq)), delay=0.1 * (seq // 3))
        decoded, envelope = reader.decode(writer.encode(message, seq, seq, 1, seq, seq))
        assert_equal(decoded, message)
        assert envelope[3:8] == (seq, seq, 1, seq, seq)


@dataclass(frozen=True, eq=False)
class Plain:
    """A type whose constant part is compared, not parsed."""

    TYPE: ClassVar[str] = "Plain/1"
    q: np.ndarray = array("n")
    delay: float = 0.0


def test_compared_and_parsed_messages_are_the_same():
    writer, repeating = Encoder(Plain, SOURCE), Decoder(Plain)
    for seq, delay in enumerate([0.0, 0.0, 0.5, 0.5, 0.0, 0.0]):
        data = writer.encode(Plain(np.array([seq, 1.0]), delay), seq, -seq, 1, seq, seq)
        one, two = repeating.decode(data), Decoder(Plain).decode(data)
        assert_equal(one[0], two[0])
        assert one[1] == two[1]
        assert one[0].delay == delay and one[1].stamp == -seq


@dataclass(frozen=True, eq=False)
class Named:
    """A type with a flat list, which is compared too."""

    TYPE: ClassVar[str] = "Named/1"
    q: np.ndarray = array("n")
    names: list[str] = dataclasses.field(default_factory=list)


def test_a_list_that_its_writer_changes_in_place_is_sent_as_it_is():
    writer, reader = Encoder(Named, SOURCE), Decoder(Named)
    message = Named(np.ones(2), ["a"])
    for name in ("a", "b", "c"):
        message.names[0] = name
        decoded, _ = reader.decode(writer.encode(message, 1, 0, 0, 0, 0))
        assert decoded.names == [name]


def test_each_decoded_message_has_lists_of_its_own():
    writer, reader = Encoder(Named, SOURCE), Decoder(Named)
    for seq in range(4):
        data = writer.encode(Named(np.ones(2), ["a"]), seq, 0, 0, 0, 0)
        decoded, _ = reader.decode(data)
        assert decoded.names == ["a"]
        decoded.names.append("mine")
    assert reader._known is not None


def test_minimal_integers_of_other_writers_are_read():
    data = pack(unpack(encode(Number(value=1.5), seq=7)))
    decoded, envelope = Decoder(Number).decode(data)
    assert (decoded.value, envelope.seq) == (1.5, 7)


@pytest.mark.parametrize("reader", [Decoder(Number)])
def test_vector_of_a_message_without_arrays(reader):
    writer = Encoder(Number, SOURCE, epoch=2)
    data = writer.encode(Number(value=1.5), seq=7, stamp=9, clock=1, acquired=10, sent=11)
    assert data.hex() == NUMBER_HEX
    assert reader.decode(bytes.fromhex(NUMBER_HEX))[0].value == 1.5


def test_vector_of_a_message_with_arrays_and_flags():
    message = mixed(
        *(2, 1),
        delay=0.25,
        on=False,
        tags=["x"],
        maps=[{"f": 1.0}],
    )
    writer = Encoder(Mixed, SOURCE, 0, "a987f610")
    data = writer.encode(message, 1, 2, 0, 3, 4, valid=False, reason="no ft")
    assert data.hex() == MIXED_HEX
    decoded, envelope = Decoder(Mixed).decode(bytes.fromhex(MIXED_HEX))
    assert_equal(decoded, message)
    assert (envelope.valid, envelope.reason, envelope.model) == (False, "no ft", "a987f610")


def test_an_optional_array_may_come_and_go():
    writer, reader = encoder(), Decoder(Mixed)
    for seq, extra in enumerate([None, np.ones(3), None, None, np.zeros(3)]):
        decoded, _ = reader.decode(writer.encode(mixed(extra=extra), seq, 0, 0, 0, 0))
        assert (decoded.extra is None) == (extra is None)


def test_arrays_that_are_not_contiguous_travel_by_their_values():
    flags = np.array([True, True, False, True, True, False])[::2]
    ft = np.asfortranarray(np.arange(12.0).reshape(2, 6))
    strided = mixed(q=np.arange(6.0)[::2], ft=ft, ok=flags)
    decoded, _ = Decoder(Mixed).decode(encode(strided))
    assert_equal(decoded, strided)


def test_unknown_fields_of_a_newer_writer_are_skipped():
    parts = unpack(encode(mixed()))
    parts[11]["new"] = 1
    parts[12].insert(0, ["newer", 2])
    parts[13] = bytes(16) + parts[13]
    decoded, _ = Decoder(Mixed).decode(pack(parts))
    assert_equal(decoded, mixed())


def test_a_field_with_a_default_may_be_missing():
    parts = unpack(encode(mixed(count=9)))
    del parts[11]["count"]
    assert Decoder(Mixed).decode(pack(parts))[0].count == 3


def test_arrays_in_lists_and_numpy_scalars_travel_as_plain_values():
    message = mixed(maps=[{"point": np.ones(3), "p": np.float64(0.5)}], count=np.int64(4))
    decoded, _ = Decoder(Mixed).decode(encode(message))
    assert decoded.maps == [{"point": [1.0, 1.0, 1.0], "p": 0.5}]
    assert decoded.count == 4


@pytest.mark.parametrize(
    ("fields", "complaint"),
    [
        ({"q": np.ones(4)}, r"field ok: expected shape \(4,\) \(n\), got \(3,\)"),
        ({"q": np.array([1.0, np.nan, 2.0])}, "field q: expected finite"),
        ({"ft": np.full((2, 6), np.inf)}, "field ft: expected finite"),
        ({"q": np.ones(3, dtype=np.float32)}, "field q: expected float64, got float32"),
        ({"q": np.ones(3, dtype=int)}, "field q: expected float64, got int64"),
        ({"q": [1.0, 2.0, 3.0]}, "field q: expected a float64 array"),
        ({"q": None}, "field q: expected a float64 array, got None"),
        ({"ok": np.ones(3)}, "field ok: expected bool"),
        ({"ft": np.ones((2, 5))}, r"field ft: expected shape \(2, 6\) \(k, 6\), got \(2, 5\)"),
        ({"delay": float("nan")}, "field delay: expected a finite number"),
        ({"count": 1.5}, "field count: expected int"),
        ({"name": 3}, "field name: expected str"),
        ({"tags": [1]}, "field tags: expected str"),
        ({"maps": [{"p": float("inf")}]}, "field maps: expected a finite number"),
        ({"maybe": 1}, "field maybe: expected str or NoneType"),
    ],
)
@pytest.mark.parametrize("warm", [False, True])
def test_a_wrong_datum_is_refused_at_the_writer(fields, complaint, warm):
    writer = encoder()
    if warm:
        writer.encode(mixed(), 1, 0, 0, 0, 0)
    with pytest.raises(WireError, match=complaint):
        writer.encode(mixed(**fields), 2, 0, 0, 0, 0)
    assert writer.encode(mixed(), 3, 0, 0, 0, 0)


def test_dimensions_bind_the_symbols():
    with pytest.raises(WireError, match=r"field q: expected shape \(5,\) \(n\), got \(3,\)"):
        encoder(dimensions={"n": 5}).encode(mixed(), 1, 0, 0, 0, 0)
    with pytest.raises(WireError, match="field ft"):
        Decoder(Mixed, dimensions={"n": 3, "k": 6}).decode(encode(mixed()))


def test_another_robots_message_is_refused():
    data = encoder(model="aaaaaaaa").encode(mixed(), 1, 0, 0, 0, 0)
    with pytest.raises(WireError, match="expected model bbbbbbbb, got 'aaaaaaaa'"):
        Decoder(Mixed, model="bbbbbbbb").decode(data)
    assert Decoder(Mixed).decode(data)[1].model == "aaaaaaaa"


def test_huge_but_finite_numbers_are_accepted_without_a_warning():
    message = mixed(q=np.full(3, 1e300))
    assert Decoder(Mixed).decode(encode(message))[0].q[0] == 1e300


@pytest.mark.parametrize(
    ("position", "value"),
    [
        *((0, other) for other in ("Other/1", 5, None, b"Mixed/1")),
        *((1, other) for other in (b"short", "x" * 16, None)),
        *((2, other) for other in (-1, 1 << 32, True, 1.0)),
        *((3, other) for other in (-1, True, "1", 0.5)),
        *((4, other) for other in (1.5, None, (1 << 63) + 5)),
        *((5, other) for other in (2, True, -1)),
        *((8, other) for other in (1, None, "true")),
        *((9, other) for other in (None, 3, b"")),
        *((10, other) for other in (None, 3)),
        *((11, other) for other in (None, [], {"ok": [True, False, 1]}, {"ok": "yes"}, {1: 2})),
        *((12, other) for other in (None, [["q", 3]], [["q", -3], ["ft", 2, 6]], ["q"], [[{}]])),
        (12, [["q", 3], ["q", 3], ["ft", 2, 6]]),
        (12, [["q", 4], ["ft", 2, 6]]),
        (12, [["q", 3], ["ft", 6, 2]]),
        (12, [["q", 3], ["ft", 2, 6], ["x", 60000, 60000, 60000]]),
        (12, [["q", 1 << 62], ["ft", 2, 6]]),
        *((13, other) for other in (b"", b"1234567", "text", None)),
        (13, np.full(15, np.nan).tobytes()),
        (13, bytes(8 * 16)),
    ],
)
def test_wrong_parts_are_refused(position, value):
    with pytest.raises(WireError):
        Decoder(Mixed).decode(repack(encode(mixed()), position, value))


@pytest.mark.parametrize("length", [0, 1, 13])
def test_truncated_and_extended_messages_are_refused(length):
    data = encode(mixed())
    for wrong in (data[:length], data[:-1], data + b"\0", data + data):
        with pytest.raises(WireError):
            Decoder(Mixed).decode(wrong)


def test_memory_of_layouts_is_bounded():
    reader, writer = Decoder(Mixed), encoder()
    for n in range(1, 200):
        reader.decode(writer.encode(mixed(n=n), n, 0, 0, 0, 0))
    assert len(reader._plans) <= 64


def test_decoded_arrays_cannot_be_changed():
    decoded, _ = Decoder(Mixed).decode(encode(mixed()))
    for vector in (decoded.q, decoded.ft, decoded.ok):
        with pytest.raises(ValueError, match="read-only"):
            vector[0] = 1


GOOD = Encoder(Plain, SOURCE).encode(Plain(np.ones(4), 0.5), 1, 2, 1, 3, 4)


def test_a_dimension_that_is_true_is_not_one_where_the_layout_is_remembered_either():
    good = encode(mixed(n=1, k=0))
    reader = Decoder(Mixed)
    reader.decode(good)
    for one in (True, 1.0):
        with pytest.raises(WireError, match="bad dimensions"):
            reader.decode(repack(good, 12, [["q", one], ["ft", 0, 6]]))


def test_deep_nesting_is_refused():
    deep = b"\x91" * 5000 + b"\xc0"
    with pytest.raises(WireError):
        Decoder(Mixed).decode(b"\x9e" + deep)


def test_a_forged_constant_part_is_not_remembered():
    """The first message's numbers have minimal width, so nothing may be compared with it."""
    reader = Decoder(Plain)
    reader.decode(pack(unpack(GOOD)))
    assert reader._known is None
    reader.decode(GOOD)
    assert reader._known is not None
