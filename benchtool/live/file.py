"""A recording as a file."""

from __future__ import annotations

from pathlib import Path

import rerun as rr

from benchtool.errors import EnvironmentFailure


class FileDestination:
    """A recording as a file, for `rerun FILE.rrd`.

    Args:
        path: the file.
        endless: leave out the index at its end, which is kept in memory until then and takes 8 MB a minute;
            `rerun rrd optimize` adds one.
    """

    def __init__(self, path: Path, *, endless: bool = False) -> None:
        self.path = path
        self._endless = endless

    @property
    def name(self) -> str:
        return str(self.path)

    @property
    def closing_s(self) -> float:
        """A slow disk gets its time."""
        return 60.0

    def connect(self, stream: rr.RecordingStream) -> None:
        """Begin the file; an older one is replaced.

        Raises:
            EnvironmentFailure: it cannot be written.
        """
        self.check()
        try:
            stream.save(self.path, write_footer=not self._endless)
        except RuntimeError as reason:
            raise self._unwritable(str(reason)) from None

    def check(self) -> None:
        """Make the file, empty if it is new, where no recording is begun yet.

        Raises:
            EnvironmentFailure: it cannot be written.
        """
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with self.path.open("ab"):
                pass
        except OSError as reason:
            raise self._unwritable(reason.strerror or str(reason)) from None

    def _unwritable(self, reason: str) -> EnvironmentFailure:
        return EnvironmentFailure(
            f"cannot write {self.path}: {reason}; the recording of the live view was to go there: "
            f"choose another file"
        )

    @property
    def another(self) -> str:
        """There is none."""
        return ""

    def alive(self) -> bool:
        """Always."""
        return True

    def give_up(self) -> None:
        """Nothing to let go of."""
