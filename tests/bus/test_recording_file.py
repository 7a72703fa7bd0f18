"""Recording files: what is written is read, with proof that nothing is missing."""

import pytest
from mcap.reader import make_reader

from bus.decoder import Decoder
from bus.recording import Recording, RecordingError, RecordingWriter
from tests.bus.recordings import INFO, SECOND, Source, make, record


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.mcap"


@pytest.fixture
def writer(path):
    with_losses = RecordingWriter(path, {"version": "1.0"})
    yield with_losses
    with_losses.abandon()


def test_messages_come_back_byte_for_byte_in_order_of_arrival(writer, path):
    source, sent = Source(), []
    channel = writer.open_channel("/a:o", INFO)
    for k in range(100):
        sent.append(source.message())
        record(writer, channel, sent[-1], SECOND + k)
        writer.flush(now=k % 30 == 0)
    writer.close()
    recording = Recording(path)
    got = list(recording.messages())
    assert [m.data for m in got] == sent
    assert [m.arrival for m in got] == [SECOND + k for k in range(100)]
    assert (recording.start, recording.end) == (SECOND, SECOND + 99)
    assert recording.ports["/a:o"].count == 100 and recording.ports["/a:o"].nominal_hz == 100.0


def test_messages_are_decoded_by_what_the_port_told_of_its_type(path):
    make(path)
    recording = Recording(path)
    decoder = Decoder(recording.ports["/b:o"].message_type())
    data, envelope = decoder.decode(next(recording.messages(["/b:o"])).data)
    assert envelope.seq == 1 and data.value == 1.0


def test_ports_and_times_are_chosen(path):
    make(path)
    recording = Recording(path)
    chosen = list(recording.messages(["/a:o"], start=3 * SECOND + 2, end=4 * SECOND + 2))
    assert {m.port for m in chosen} == {"/a:o"}
    assert [m.arrival for m in chosen] == [3 * SECOND + k for k in range(2, 8)] + [
        4 * SECOND,
        4 * SECOND + 1,
    ]
    with pytest.raises(RecordingError, match="no .*/c:o.*it has .*/a:o"):
        next(recording.messages(["/c:o"]))


def test_chunks_that_overlap_in_time_are_merged(writer, path):
    channel, source = writer.open_channel("/a:o", INFO), Source()
    for first in (0, 5, 2):
        for k in range(10):
            record(writer, channel, source.message(), SECOND + 10 * (first + k))
        writer.flush(now=True)
    writer.close()
    arrivals = [m.arrival for m in Recording(path).messages()]
    assert len(arrivals) == 30 and arrivals == sorted(arrivals)


def test_gaps_repetitions_and_sources_are_counted_per_port(writer, path):
    channel, first, second = writer.open_channel("/a:o", INFO), Source(), Source()
    for data in (first.message(), first.message(skip=3), second.message(), second.message(skip=1)):
        record(writer, channel, data, SECOND)
        record(writer, channel, data, SECOND)
    writer.close()
    losses = Recording(path).metadata["losses/a:o"]
    assert (losses["recorded"], losses["lost"], losses["repeated"]) == ("4", "4", "4")
    assert losses["sources"] == "2"


def test_a_port_whose_type_changes_has_a_channel_for_each(writer, path):
    source = Source()
    old = writer.open_channel("/a:o", INFO)
    assert writer.open_channel("/a:o", INFO) == old
    record(writer, old, source.message(), SECOND)
    new = writer.open_channel("/a:o", {**INFO, "type": "Number/2"})
    assert new != old
    record(writer, new, source.message(), SECOND + 1)
    writer.close()
    recording = Recording(path)
    assert [(port.type, port.count) for port in recording.channels] == [
        ("Number/1", 1),
        ("Number/2", 1),
    ]
    assert recording.ports["/a:o"].type == "Number/2" and recording.ports["/a:o"].count == 2


def test_a_file_that_exists_is_only_replaced_when_told(path):
    make(path)
    before = path.read_bytes()
    with pytest.raises(FileExistsError):
        RecordingWriter(path, {})
    assert path.read_bytes() == before
    RecordingWriter(path, {"version": "2"}, overwrite=True).close()
    assert Recording(path).metadata["recording"]["version"] == "2"


def test_other_programs_read_the_file_with_the_library_alone(path):
    make(path)
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert sum(1 for _ in reader.iter_messages()) == 2 * 6 * 8
        assert [a.name for a in reader.iter_attachments()] == ["config/a.json"]


def test_what_is_no_recording_is_refused_by_name(tmp_path):
    for content in (b"", b"x", b"stamp,q\n" * 100):
        file = tmp_path / "table.csv"
        file.write_bytes(content)
        with pytest.raises(RecordingError, match="table.csv: not an MCAP file"):
            Recording(file)
    with pytest.raises(RecordingError, match="nothing.mcap: No such file"):
        Recording(tmp_path / "nothing.mcap")
