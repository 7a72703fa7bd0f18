"""``wrenchbus graph``: the Enhanced Oriented Graph of a robot as a picture."""

from pathlib import Path
from typing import Annotated

import typer

from deploy.errors import CommandError, UsageError
from deploy.graph_picture.view import View
from deploy.options import Description
from deploy.output import print_line


def graph(
    robot: Description = "icub",
    contact: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FRAME[:X,Y,Z][:wrench|force|none|direction=X,Y,Z]",
            help="Link or frame that is touched, and the point in it [m]; repeatable.",
        ),
    ] = None,
    support: Annotated[
        str | None, typer.Option(help="What bears the robot; default: floor, if it has one.")
    ] = None,
    view: Annotated[
        View, typer.Option(help="Both kinds of symbols, triangles only, or rhombi only.")
    ] = View.all,
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FILE", help="SVG file to write.")
    ] = Path("graph.svg"),
) -> None:
    """Draw a robot's Enhanced Oriented Graph: links, joints, sensors, unknown wrenches.

    Each contact takes the place of the default contact of its sub-graph.
    """
    picture = _picture(robot, contact or [], support, view)
    try:
        output.write_text(picture)
    except OSError as error:
        raise CommandError(f"cannot write {output}: {error.strerror}") from None
    print_line(f"wrote {output}")


def _picture(name: str, contacts: list[str], support: str | None, view: View) -> str:
    """Return the SVG; what the user got wrong is a UsageError."""
    from deploy.contacts import read_touch, support_of
    from deploy.graph_picture.picture import graph_svg
    from estimation.contact_set import contact_set
    from estimation.graph.enhanced_graph import enhanced_graph
    from robot_model import DescriptionError, load_robot

    touches = [read_touch(text) for text in contacts]
    try:
        robot = load_robot(name)
        support = support_of(robot, support)
        placed = contact_set(robot, support, touches)
    except (DescriptionError, LookupError, ValueError) as error:
        raise UsageError(str(error)) from None
    names = [subtree.name for subtree in robot.subtrees]
    notes = {contact.frame: f"({contact.kind})" for contact in placed}
    root = robot.frame(robot.base_link)[0]
    return graph_svg(enhanced_graph(robot, placed), root, names, notes, view)
