"""All tests may use the bus's own test kit; on request, a skipped test is a failure."""

import signal
from collections.abc import Iterator

import pytest

pytest_plugins = ["bus.testing"]


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add what continuous integration asks for."""
    parser.addoption("--fail-on-skip", action="store_true", help="a skipped test is a failure")


def pytest_configure() -> None:
    """Let SIGTERM end the run as Ctrl-C does: the fixtures stop what they have started."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)


@pytest.fixture(scope="session", autouse=True)
def _no_files_of_the_user(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Wishes and recordings of the tests are none of the user's."""
    with pytest.MonkeyPatch.context() as patch:
        for variable in ("XDG_STATE_HOME", "XDG_DATA_HOME"):
            patch.setenv(variable, str(tmp_path_factory.mktemp(variable.lower())))
        yield


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail a run in which something was skipped; the summary (-rs) says what and why."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    asked = session.config.getoption("--fail-on-skip")
    if asked and reporter and reporter.stats.get("skipped"):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
