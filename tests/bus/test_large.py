"""Large payloads: pictures and arrays of 1 MB, limits of ports and of the link."""

import time

import numpy as np
import pytest

from bus import Node, WireError
from bus.session import MAX_MESSAGE
from bus.testing import collect, eventually
from tests.bus.messages import Mixed, Number, Picture, mixed

MB = 1 << 20


def picture(k: int) -> Picture:
    return Picture(height=640, width=1638, pixels=bytes([k]) * 640 * 1638)


def arrived(node, inp, k: int) -> bool:
    """Whether a picture has come within a second.

    A loaded link drops some of a state, and is made anew when a command has to wait.
    """
    until = time.monotonic() + 1.0
    while time.monotonic() < until:
        node.wait(0.01)
        if (received := inp.newest()) and received.data.pixels == picture(k).pixels:
            return True
    return False


def ready(*nodes):
    for node in nodes:
        node.ready()


@pytest.mark.parametrize("reliable", [False, True], ids=["state", "command"])
def test_pictures_of_one_megabyte_arrive_whole_and_in_order(writer, node, reliable):
    out = writer.output("/w/camera:o", Picture, max_message=2 * MB, reliable=reliable)
    inp = node.input("/r/camera:i", Picture, "/w/camera:o", depth=8, max_message=2 * MB)
    ready(writer, node)
    eventually(lambda: out.matched and node.directory.leader("/w/camera:o"))
    for k in range(20):
        out.write(picture(k))
        eventually(lambda k=k: arrived(node, inp, k) or out.write(picture(k)))
    assert inp.statistics.refused == 0
    assert not reliable or inp.statistics.lost <= out.statistics.written - 20


def test_arrays_of_one_megabyte_arrive_whole(writer, node):
    out = writer.output("/w/cloud:o", Mixed, max_message=4 * MB)
    inp = node.input("/r/cloud:i", Mixed, "/w/cloud:o", depth=8, max_message=4 * MB)
    ready(writer, node)
    eventually(lambda: out.matched and node.directory.leader("/w/cloud:o"))
    sent = mixed(n=2, k=MB // 48)
    received = eventually(lambda: (out.write(sent), node.wait(1.0), inp.newest())[-1])
    assert np.array_equal(received.data.ft, sent.ft)


def test_what_exceeds_a_ports_own_limit_is_counted_and_delays_nobody(hub, writer, node):
    """One reader takes pictures, another one only small ones; both read a fast small port."""
    camera = writer.output("/w/camera:o", Picture, max_message=2 * MB)
    fast = writer.output("/w/fast:o", Number, rate=100.0)
    inputs = []
    with Node("small", connect=hub, signals=False) as small:
        for reader, limit in ((node, 2 * MB), (small, 65536)):
            name = reader.name
            inputs.append(
                (
                    reader,
                    reader.input(f"/{name}/camera:i", Picture, "/w/camera:o", max_message=limit),
                    reader.input(f"/{name}/fast:i", Number, "/w/fast:o", depth=64, rate=100.0),
                )
            )
        ready(writer, node, small)
        eventually(lambda: all(r.directory.leader("/w/camera:o") for r, _, _ in inputs))
        eventually(lambda: camera.matched and fast.matched)
        worst = 0.0
        for k in range(30):
            began = time.monotonic()
            camera.write(picture(k))
            fast.write(Number(value=time.monotonic()))
            worst = max(worst, time.monotonic() - began)
            for reader, _, numbers in inputs:
                (received,) = collect(reader, numbers, 1)  # passes the picture
                assert time.monotonic() - received.data.value < 5.0
        assert worst < 2.0  # 3 ms on a quiet machine
        (_, whole, one), (_, refused, two) = inputs
        eventually(lambda: (whole.newest(), whole.statistics.received >= 1)[1])
        assert whole.statistics.refused == 0
        eventually(lambda: refused.read() is None and refused.statistics.refused > 0)
        statistics = refused.statistics
        assert statistics.received == 0 and statistics.refused + statistics.dropped <= 30
        assert one.statistics.lost == two.statistics.lost == 0


def test_a_small_message_after_one_that_was_refused_is_read(writer, node):
    out = writer.output("/w/camera:o", Picture, max_message=2 * MB)
    inp = node.input("/r/camera:i", Picture, "/w/camera:o", depth=8)
    ready(writer, node)
    eventually(lambda: out.matched and node.directory.leader("/w/camera:o"))
    out.write(picture(1))
    out.write(Picture(height=1, width=2, pixels=b"ab"))
    (received,) = collect(node, inp, 1)
    assert received.data.pixels == b"ab"
    assert (inp.statistics.refused, inp.statistics.lost) == (1, 0)


def test_a_message_as_large_as_the_link_allows_travels_and_a_larger_one_stops_nothing(writer, node):
    limit = 4 * MAX_MESSAGE
    out = writer.output("/w/huge:o", Picture, max_message=limit)
    inp = node.input("/r/huge:i", Picture, "/w/huge:o", depth=8, max_message=limit)
    ready(writer, node)
    eventually(lambda: out.matched and node.directory.leader("/w/huge:o"))
    out.write(Picture(height=1, width=1, pixels=bytes(MAX_MESSAGE - 1024)))
    assert len(collect(node, inp, 1)[0].data.pixels) == MAX_MESSAGE - 1024

    def small_comes():
        out.write(Picture(height=1, width=1, pixels=b"x"))
        node.wait(0.01)
        return (received := inp.newest()) and received.data.pixels == b"x"

    try:
        out.write(Picture(height=1, width=1, pixels=bytes(2 * MAX_MESSAGE)))
    except WireError:
        pass  # the port itself refuses
    eventually(small_comes)
