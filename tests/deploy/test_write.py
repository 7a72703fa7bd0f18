"""``write``: messages from the command line onto inputs and under names of its own."""

import threading

import pytest

from bus import NameTaken, Node
from bus.introspection import port_info
from bus.testing import collect, eventually
from deploy.writer import Writer
from tests.bus.messages import Number

IN, OUT = "/toy/in:i", "/toy/out:o"


@pytest.fixture
def heard(toy_bus):
    """Return ``heard(count)``: the next valid values that the toy, which doubles, writes."""
    with Node("hearer", connect=toy_bus, signals=False) as node:
        entry = node.input("/hearer/in:i", Number, source=OUT, depth=4096)
        collect(node, entry, 1)

        def values(count):
            found = []

            def enough():
                node.wait(0.01)
                while (received := entry.read()) is not None:
                    found.extend([received.data.value] if received.envelope.valid else [])
                return len(found) >= count

            eventually(enough, what=f"{count} valid values")
            return found

        yield values


def test_a_message_on_the_command_line_reaches_an_input(verb, heard):
    assert verb("write", IN, "value=1.5") == (0, "", "")
    assert verb("write", IN, '{"value": 4}') == (0, "", "")
    assert heard(2) == [3.0, 8.0]


def test_each_line_of_standard_input_is_a_message(verb, heard, typed):
    typed('value=1\n\n{"value": 2}\nvalue=3e0')
    assert verb("write", IN) == (0, "", "")
    assert heard(3) == [2.0, 4.0, 6.0]


def test_a_bad_line_is_told_with_its_number_after_the_good_ones(verb, heard, typed):
    typed("value=1\nvalue=x\n")
    result = verb("write", IN)
    assert result.status == 2 and "line 2: field value: expected a finite number" in result.err
    assert heard(1) == [2.0]


def test_an_unknown_field_is_wrong_usage_with_near_names(verb):
    result = verb("write", IN, "valeu=1")
    assert result.status == 2 and "did you mean value?" in result.err


def test_an_output_that_stands_is_not_written_by_others(verb):
    result = verb("write", OUT, "value=1")
    assert result.status == 2 and "is written by toy (host " in result.err
    assert result.err.count("\n") == 1


def test_a_new_output_needs_a_type(verb):
    result = verb("write", "/mine:o", "value=1")
    assert result.status == 2 and "--type-of PORT" in result.err


def test_a_new_output_is_written_to_who_waits_for_it(verb, toy_bus):
    with Node("friend", connect=toy_bus, signals=False) as node:
        entry = node.input("/friend/in:i", Number, source="/mine:o", depth=16)
        node.ready()
        assert verb("write", "/mine:o", "value=7", "--type-of", OUT) == (0, "", "")
        [received] = collect(node, entry, 1)
    assert received.data.value == 7.0 and received.envelope.valid


def test_a_new_output_describes_its_messages_as_the_port_that_lent_the_type(toy_bus):
    with Node("mine", connect=toy_bus, signals=False) as node, Writer(node, "/mine:o", OUT):
        described = [node.ports.get("/mine:o").info(), port_info(node, OUT)]
        assert [told["description"] for told in described] == ["One number."] * 2
        assert described[0]["fields"] == described[1]["fields"]


@pytest.fixture
def choosy(toy_bus):
    """An input that takes messages of one robot only, read by a thread."""
    with Node("choosy", connect=toy_bus, signals=False) as node:
        entry = node.input("/choosy/in:i", Number, model="01234567", depth=16)
        node.ready()

        def work():
            while node.running:
                node.wait(0.01)
                entry.newest()

        reader = threading.Thread(target=work)
        reader.start()
        yield "/choosy/in:i"
        node.stop()
        reader.join()


def test_what_an_input_refuses_is_told(verb, choosy):
    result = verb("write", choosy, "value=1", "--model", "89abcdef")
    assert result.status == 1 and "took 0 of 1 messages" in result.err and "choosy" in result.err


def test_a_model_may_be_given_for_an_input_that_asks_for_it(verb, choosy):
    assert verb("write", choosy, "value=1", "--model", "01234567") == (0, "", "")


def test_an_output_that_stands_is_taken_over_in_a_higher_epoch(verb, toy_bus):
    with (
        Node("owner", connect=toy_bus, signals=False) as owner,
        Node("friend", connect=toy_bus, signals=False) as friend,
    ):
        out = owner.output("/taken:o", Number)
        entry = friend.input("/friend/in:i", Number, source="/taken:o", depth=16)
        owner.ready()
        friend.ready()
        assert verb("write", "/taken:o", "value=7", "--take-over") == (0, "", "")
        [received] = collect(friend, entry, 1)
        assert received.data.value == 7.0 and received.envelope.epoch == 1
        with pytest.raises(NameTaken, match="lost /taken:o: .* taken by wrenchbus-"):
            eventually(lambda: owner.wait(0.05) and False)
        assert not out.standing


def test_only_an_output_is_taken_over(verb):
    result = verb("write", IN, "value=1", "--take-over")
    assert result.status == 2 and "takes the name of an output (:o), got /toy/in:i" in result.err
