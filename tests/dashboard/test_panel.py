"""What the panel says besides data."""

import pytest

from dashboard.config import DashboardConfig
from dashboard.panel import Panel


@pytest.fixture
def said(server, robot, monkeypatch):
    """Return ``said()``: the texts of a new panel."""

    def texts() -> str:
        told: list[str] = []
        add = server.gui.add_html

        def note(content: str, *arguments, **more):
            told.append(content)
            return add(content, *arguments, **more)

        monkeypatch.setattr(server.gui, "add_html", note)
        Panel(server.gui, robot, ("l_forearm",), DashboardConfig())
        return "\n".join(told)

    return texts


def test_links_that_leave_the_machine_unprotected_are_told_on_the_page(said, monkeypatch):
    monkeypatch.setattr("bus.session._unprotected", ["tcp/10.0.0.1:7512"])
    shown = said()
    assert "everybody on the network can read and move the robot" in shown
    assert "tcp/10.0.0.1:7512" in shown


def test_on_one_machine_nothing_is_said_of_that(said, monkeypatch):
    monkeypatch.setattr("bus.session._unprotected", [])
    assert "insecure" not in said()
