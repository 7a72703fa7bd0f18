"""A linked peer whose names do not come, though the hub has them, is linked anew."""

from bus import Node, links, reunion
from bus.testing import collect, eventually
from tests.bus.messages import Number


def link_with(node: Node, peer: Node) -> set[tuple[str, str]]:
    other = str(peer.session.zid())
    found = node.session.info.links()
    return {(link.src, link.dst) for link in found if str(link.zid) == other}


def test_a_link_without_names_is_made_anew(monkeypatch, hub, writer):
    monkeypatch.setattr(reunion, "GATHERING", 0.2)
    out = writer.output("/w/x:o", Number)
    writer.ready()
    with Node("reader", connect=hub, signals=False) as reader:
        inp = reader.input("/reader/x:i", Number, source="/w/x:o", depth=8)
        reader.ready()
        before = eventually(lambda: link_with(reader, writer))
        links.expect_names(reader.session, set)
        with Node("newcomer", connect=hub, signals=False):  # so that links are looked at
            eventually(lambda: not before & link_with(reader, writer))
        links.expect_names(reader.session, reader.directory.sessions)
        eventually(lambda: out.matched and reader.directory.leader("/w/x:o"))
        out.write(Number(value=1.0))
        assert collect(reader, inp, 1)[0].data.value == 1.0


def test_a_link_with_names_is_left_alone(monkeypatch, hub, writer):
    monkeypatch.setattr(reunion, "GATHERING", 0.05)
    closed, looks = [], []
    monkeypatch.setattr(reunion, "close_connection", lambda *ends: closed.append(ends))
    known = writer.directory.sessions
    links.expect_names(writer.session, lambda: looks.append(1) or known())
    writer.output("/w/x:o", Number)
    writer.ready()
    with Node("reader", connect=hub, signals=False) as reader:
        reader.ready()
        eventually(lambda: link_with(writer, reader) and looks)
        assert not closed
