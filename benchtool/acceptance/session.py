"""A session of the shipped suite, run by pytest in this process."""

from __future__ import annotations

import importlib.util
import io
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from typing import TYPE_CHECKING, Any

from benchtool.acceptance.scores import SUITE
from benchtool.errors import EnvironmentFailure

if TYPE_CHECKING:
    import pytest

    from benchtool.results import SessionRecord

_PLUGIN = "benchtool.acceptance.plugin"


def run_suite(arguments: Sequence[str], *, quiet: bool = False) -> tuple[int, SessionRecord | None]:
    """Run the shipped suite with pytest; return its exit code and the record of the session.

    The configuration of the folder from which it is called does not matter.

    Args:
        arguments: further options of pytest, such as `--bench PROFILE`.
        quiet: print nothing.

    Raises:
        EnvironmentFailure: pytest is not there.
    """
    if importlib.util.find_spec("pytest") is None:
        raise EnvironmentFailure(
            "the acceptance suite needs pytest, which is not installed: pip install 'benchtool[acceptance]'"
        )
    if "-n" in arguments and importlib.util.find_spec("xdist") is None:
        raise EnvironmentFailure(
            "several benches at a time need pytest-xdist, which is not installed: pip install pytest-xdist"
        )
    import pytest

    gathered = _Gathered()
    words = [
        *("-c", str(SUITE / "pytest.ini"), f"--rootdir={SUITE}", "-p", _PLUGIN, "-p", "no:cacheprovider"),
        *("-W", "ignore::pytest.PytestAssertRewriteWarning"),  # this process has the package already
        *(str(SUITE), *arguments),
    ]
    if not quiet:
        return int(pytest.main(words, plugins=[gathered])), gathered.record
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        return int(pytest.main(words, plugins=[gathered])), gathered.record


class _Gathered:
    """Keeps the record of a session."""

    record: SessionRecord | None = None

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Take the record from the plugin, if a session began."""
        log: Any = session.config.pluginmanager.get_plugin(f"{_PLUGIN}.session")
        if log is not None:
            self.record = log.record()
