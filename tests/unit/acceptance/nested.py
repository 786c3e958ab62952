"""A session of pytest within a test, in the same process."""

from __future__ import annotations

import io
import itertools
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from benchtool.acceptance.plugin import NAME
from benchtool.results import SessionRecord, TestRecord

_numbers = itertools.count(1)


@dataclass(frozen=True)
class Ran:
    """What a session left."""

    code: int
    text: str
    record: SessionRecord | None
    config: pytest.Config

    def __getitem__(self, name: str) -> TestRecord:
        assert self.record is not None
        (found,) = [each for each in self.record.tests if each.name.endswith(f"::{name}")]
        return found


class _Gathered:
    record: SessionRecord | None = None
    config: pytest.Config | None = None

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        self.config = session.config
        log: Any = session.config.pluginmanager.get_plugin(f"{NAME}.session")
        self.record = None if log is None else log.record()


def run_pytest(folder: Path, source: str, *words: str, plugins: tuple[object, ...] = ()) -> Ran:
    """Run the tests in a source with further options; the file lies in `folder`."""
    file = folder / f"test_{next(_numbers)}_it.py"  # modules stay imported in this process
    file.write_text(source, encoding="utf-8")
    (folder / "pytest.ini").write_text("[pytest]\naddopts = --import-mode=importlib\n", encoding="utf-8")
    gathered, text = _Gathered(), io.StringIO()
    own = ["-c", str(folder / "pytest.ini"), f"--rootdir={folder}", "-p", NAME, "-p", "no:cacheprovider"]
    with redirect_stdout(text), redirect_stderr(text):
        code = pytest.main([*own, "-p", "no:xdist", str(file), *words], plugins=[gathered, *plugins])
    config = gathered.config
    if config is None:  # the session did not begin
        config = pytest.Config.fromdictargs({}, [])
    return Ran(int(code), text.getvalue(), gathered.record, config)
