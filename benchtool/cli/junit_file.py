"""The file of `run --junit`: written however a run ends, so that none is left of an earlier run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from benchtool.errors import BenchError


@dataclass
class JunitFile:
    """Where the verdicts of a run are to be written, if anywhere, and the folder of its bundles once there is
    one."""

    path: Path | None
    folder: Path | None = None

    def write(self, failure: BaseException | None = None, of: str = "") -> None:
        """Write what was recorded, and with what failure the run `of` a plan ended, if with one.

        Raises:
            RecordingError: it cannot be written.
        """
        if self.path is None:
            return
        from benchtool.recording import MANIFEST
        from benchtool.report import BrokenOff, write_junit
        from benchtool.results import recorded_runs

        is_recorded = self.folder is not None and any(self.folder.rglob(MANIFEST))
        runs = recorded_runs(self.folder) if self.folder is not None and is_recorded else ()
        broken_off = None
        if failure is not None:
            lines = (str(failure) or "interrupted", *getattr(failure, "__notes__", ()))
            broken_off = BrokenOff(of, "\n".join(lines))
        write_junit(runs, self.path, broken_off)


@contextmanager
def junit_file(name: str, path: Path | None) -> Iterator[JunitFile]:
    """Yield the file of a run by the name of its plan; a run that fails is written with its failure.

    What writing needs is imported where there is a file, so that a typing error does not wait for it.
    """
    if path is not None:
        from benchtool.recording import require_file

        require_file(path)
    file = JunitFile(path)
    try:
        yield file
    except (BenchError, OSError, KeyboardInterrupt) as failure:
        try:
            file.write(failure, name)
        except (BenchError, OSError) as unwritten:
            failure.add_note(f"nor is there a JUnit file: {unwritten}")
        raise
