"""Recordings that were cut or spoilt: an error that names the place, or a rescue, never a lie."""

import errno
import random
import resource
from contextlib import contextmanager

import pytest

from bus.recording import Recording, RecordingError, RecordingWriter
from bus.recording.repair import repair
from tests.bus.recordings import INFO, SECOND, Source, make, record

ALL = 2 * 6 * 8  # messages
PLACE = r"byte \d+|not an MCAP file|of another program"


@pytest.fixture
def good(tmp_path):
    path = tmp_path / "good.mcap"
    make(path)
    return path


def everything(path):
    """Return all that a recording holds."""
    recording = Recording(path)
    messages = [(m.port, m.data, m.arrival) for m in recording.messages()]
    kept = {k: v for k, v in recording.metadata.items() if not k.startswith("repair")}
    return messages, kept, recording.attachments, recording.ports


def rescued(spoilt, new):
    """Return the messages that a repair brings back, or None when it says that there are none."""
    try:
        done = repair(spoilt, new, overwrite=True)
    except RecordingError as error:
        assert spoilt.name in str(error)
        return None, None
    messages, _, attachments, _ = everything(new)
    assert len(messages) == done.messages
    assert set(attachments) <= {"config/a.json"}
    assert all(content == b'{"gain": 1.5}' for content in attachments.values())
    return messages, done


def test_a_file_cut_anywhere_is_refused_with_the_place_and_rescued(good, tmp_path):
    whole, raw = everything(good)[0], good.read_bytes()
    cut, counts = tmp_path / "cut.mcap", []
    for length in range(0, len(raw), max(len(raw) // 300, 1)):
        cut.write_bytes(raw[:length])
        with pytest.raises(RecordingError, match=PLACE):
            Recording(cut)
        messages, _ = rescued(cut, tmp_path / "new.mcap")
        counts.append(len(messages or ()))
        assert (messages or []) == whole[: counts[-1]]  # what was flushed before the cut
        assert counts[-1] % 16 == 0  # whole chunks
    assert len(counts) >= 300 and counts == sorted(counts) and counts[-1] == ALL


def test_flipped_bytes_are_noticed_or_without_effect(good, tmp_path):
    whole, raw = everything(good), good.read_bytes()
    order, spoilt, noticed = random.Random(4), tmp_path / "spoilt.mcap", 0
    for _ in range(400):
        place, bit = order.randrange(len(raw)), 1 << order.randrange(8)
        spoilt.write_bytes(raw[:place] + bytes([raw[place] ^ bit]) + raw[place + 1 :])
        try:
            assert everything(spoilt) == whole, f"byte {place}"
        except RecordingError as error:
            assert str(spoilt) in str(error)
            noticed += 1
    assert noticed > 200


def test_a_repair_gives_up_the_spoilt_chunk_only_and_says_which_bytes(good, tmp_path):
    whole, raw = everything(good)[0], good.read_bytes()
    order, spoilt, chunks = random.Random(5), tmp_path / "spoilt.mcap", 0
    for _ in range(300):
        place = order.randrange(8, len(raw))
        wrong = raw[place] ^ order.randrange(1, 256)
        spoilt.write_bytes(raw[:place] + bytes([wrong]) + raw[place + 1 :])
        messages, done = rescued(spoilt, tmp_path / "new.mcap")
        assert set(messages) <= set(whole)
        assert len(messages) >= ALL - 16, f"byte {place}: {done}"
        if len(messages) < ALL:
            chunks += 1
            assert any(gap.start <= place < gap.end for gap in done.given_up), f"{place}: {done}"
            assert done.missing in (None, ALL - len(messages))
    assert chunks > 30


@pytest.mark.parametrize("length", [1, 100, 1500])
def test_zeros_and_noise_in_the_middle_cost_only_what_they_cover(good, tmp_path, length):
    whole, raw = everything(good)[0], good.read_bytes()
    order, spoilt = random.Random(length), tmp_path / "spoilt.mcap"
    for fill in (bytes(length), order.randbytes(length)):
        for _ in range(30):
            place = order.randrange(len(raw) - length)
            spoilt.write_bytes(raw[:place] + fill + raw[place + length :])
            messages, done = rescued(spoilt, tmp_path / "new.mcap")
            assert set(messages) <= set(whole)
            assert len(messages) >= ALL - 16 * (2 + length // 500), f"{place}: {done}"


def test_the_repair_of_a_whole_file_is_the_same_recording(good, tmp_path):
    done = repair(good, tmp_path / "new.mcap")
    before, after = everything(good), everything(tmp_path / "new.mcap")
    assert done.whole and done.messages == ALL and done.missing == 0
    assert before[0] == after[0] and before[2:] == after[2:]
    assert after[1]["recording"].pop("repaired_from") == "good.mcap" and before[1] == after[1]


def test_a_repair_replaces_nothing_and_not_itself(good, tmp_path):
    with pytest.raises(RecordingError, match="File exists"):
        repair(good, good)
    with pytest.raises(RecordingError, match="not repaired into itself"):
        repair(good, good, overwrite=True)
    assert Recording(good).ports


def test_gaps_that_a_spoilt_chunk_leaves_are_counted_as_losses(good, tmp_path):
    raw = bytearray(good.read_bytes())
    third = [k for k in range(len(raw)) if raw[k : k + 7] == b"\x03\0\0\0lz4"][2]
    raw[third + 40] ^= 1
    good.write_bytes(raw)
    repair(good, tmp_path / "new.mcap")
    losses = Recording(tmp_path / "new.mcap").metadata["losses/a:o"]
    assert losses["lost"] == "8" and losses["recorded"] == "40"


@contextmanager
def small_disk():
    """No file of this process grows beyond 30 kB meanwhile, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_is_an_error_and_what_was_flushed_is_rescued(tmp_path):
    path = tmp_path / "full.mcap"
    writer, source = RecordingWriter(path, {}), Source()
    channel, flushed = writer.open_channel("/a:o", INFO), 0
    with small_disk():
        with pytest.raises(OSError) as error:
            for k in range(10_000):
                record(writer, channel, source.message(k * 1.1), SECOND + k)
                if k % 100 == 99:
                    writer.flush(now=True)
                    flushed = k + 1
        writer.abandon()
    assert error.value.errno in (errno.EFBIG, errno.ENOSPC)
    with pytest.raises(RecordingError, match="not finished, cut at byte 30000"):
        Recording(path)
    done = repair(path, tmp_path / "new.mcap")
    assert done.messages == flushed > 0
