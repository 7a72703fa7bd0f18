"""All tests may use the bus's own test kit; on request, a skipped test is a failure."""

import pytest

pytest_plugins = ["bus.testing"]


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add what continuous integration asks for."""
    parser.addoption("--fail-on-skip", action="store_true", help="a skipped test is a failure")


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail a run in which something was skipped; the summary (-rs) says what and why."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    asked = session.config.getoption("--fail-on-skip")
    if asked and reporter and reporter.stats.get("skipped"):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
