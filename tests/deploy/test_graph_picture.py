"""``wrenchbus graph``: what the picture shows."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

from deploy.graph_picture.layout import Shape, lay_out
from deploy.graph_picture.picture import graph_svg
from deploy.graph_picture.view import View
from deploy.main import run
from estimation.contact_set import contact_set
from estimation.graph.enhanced_graph import EnhancedGraph, enhanced_graph
from robot_model import Robot, load_robot

ROOT = Path(__file__).parents[2]
ARM = ROOT / "tests" / "robot_model" / "data" / "arm.yaml"
SVG = "{http://www.w3.org/2000/svg}"

IN_DOCS = {
    "graph_icub_kinematic": ["--view", "kinematic"],
    "graph_icub_dynamic": ["--view", "dynamic"],
    "graph_icub_touched": ["--contact", "l_forearm:0,0,0.05", "--contact", "head"],
}


@pytest.fixture(scope="module")
def icub() -> Robot:
    return load_robot("icub")


@pytest.fixture(scope="module")
def graph(icub: Robot) -> EnhancedGraph:
    return enhanced_graph(icub, contact_set(icub, "floor"))


def drawn(graph: EnhancedGraph, robot: Robot, view: View = View.all) -> ElementTree.Element:
    names = [subtree.name for subtree in robot.subtrees]
    return ElementTree.fromstring(graph_svg(graph, robot.base_link, names, view=view))


def texts(picture: ElementTree.Element, kind: str) -> list[str | None]:
    return [item.text for item in picture.iter(SVG + "text") if item.get("class") == kind]


@pytest.mark.parametrize("name", IN_DOCS)
def test_the_pictures_in_the_docs_are_what_the_command_draws(name, tmp_path, capsys):
    file = tmp_path / "graph.svg"
    assert run(["graph", "--robot", "icub", *IN_DOCS[name], "-o", str(file)]) == 0
    assert capsys.readouterr().out == f"wrote {file}\n"
    assert file.read_text() == (ROOT / "docs" / "images" / f"{name}.svg").read_text()


def test_every_link_joint_and_sensor_is_named_once(graph, icub):
    picture = drawn(graph, icub)
    assert sorted(texts(picture, "link")) == sorted(graph.links)
    assert sorted(texts(picture, "edge")) == sorted(edge.name for edge in graph.edges)
    leaves = [leaf.name for leaf in (*graph.inertial, *graph.unknown)]
    ends = [""] * len(graph.kinematic_ends)
    assert sorted(text or "" for text in texts(picture, "leaf")) == sorted(leaves + ends)
    assert {subtree.name for subtree in icub.subtrees} <= set(texts(picture, "legend"))


def test_links_of_a_subgraph_share_a_colour_that_no_other_has(graph, icub):
    nodes = list(lay_out(graph, icub.base_link).below())
    circles = [item.get("fill") for item in drawn(graph, icub).iter(SVG + "circle")]
    links = [node for node in nodes if node.shape in (Shape.link, Shape.sublink)]
    pairs = {(node.subgraph, fill) for node, fill in zip(links, circles, strict=False)}
    assert len(pairs) == len({fill for _, fill in pairs}) == len(icub.subtrees) == 7


def test_no_two_nodes_lie_in_one_place(graph, icub):
    nodes = list(lay_out(graph, icub.base_link).below())
    assert len({(node.column, node.row) for node in nodes}) == len(nodes)


@pytest.mark.parametrize(
    ("view", "missing"),
    [
        (View.kinematic, {Shape.unknown, Shape.known, Shape.sublink}),
        (View.dynamic, {Shape.inertial, Shape.motion}),
    ],
)
def test_a_view_shows_its_own_symbols_only(graph, icub, view, missing):
    shapes = {node.shape for node in lay_out(graph, icub.base_link, view).below()}
    assert not shapes & missing
    shown = set(texts(drawn(graph, icub, view), "legend"))
    assert not shown & {shape.value for shape in missing}


def test_an_edge_that_is_turned_has_its_head_at_the_other_end():
    robot = load_robot(ARM)
    graph = enhanced_graph(robot)
    lines = [
        [line.get("points") for line in drawn(each, robot, View.dynamic).iter(SVG + "polyline")]
        for each in (graph, graph.turned(["bend"]))
    ]
    changed = [(a, b) for a, b in zip(*lines, strict=True) if a != b]
    assert [a.split() for a, _ in changed] == [b.split()[::-1] for _, b in changed]
    assert len(changed) == 1


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--robot", "icup"], "did you mean 'icub'?"),
        (["--contact", "l_forerm"], "did you mean 'l_forearm'?"),
        (["--contact", "l_forearm:1,2"], "expected X,Y,Z"),
        (["--contact", "l_foot:none"], "touched at 'l_sole'"),
        (["--support", "flor"], "no support 'flor'"),
        (["--view", "static"], "static"),
    ],
)
def test_a_wrong_wish_is_one_line_and_status_2(arguments, expected, capsys):
    assert run(["graph", *arguments]) == 2
    shown = capsys.readouterr()
    assert expected in shown.err and shown.err.count("\n") == 1 and shown.out == ""


def test_supports_that_share_a_subgraph_are_both_drawn(tmp_path):
    file = tmp_path / "graph.svg"
    assert run(["graph", "--robot", str(ARM.with_name("talos.yaml")), "-o", str(file)]) == 0
    drawn = file.read_text()
    assert "left_sole_link" in drawn and "right_sole_link" in drawn


def test_a_file_that_cannot_be_written_is_one_line_and_status_1(tmp_path, capsys):
    assert run(["graph", "--robot", str(ARM), "-o", str(tmp_path / "no" / "graph.svg")]) == 1
    assert "cannot write" in capsys.readouterr().err
