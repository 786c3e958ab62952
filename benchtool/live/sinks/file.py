"""A recording as a file."""

from __future__ import annotations

import os
import shutil
import time
from pathlib import Path
from typing import Final

import rerun as rr

from benchtool.errors import EnvironmentFailure

_LOOKING_S: Final = 1.0
_ROOM_B: Final = 32 << 20
"""Free space to leave: the SDK may never return from writing to a full disk."""


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
        self._look_s = 0.0
        self._room = True

    @property
    def name(self) -> str:
        return str(self.path)

    @property
    def closing_timeout_s(self) -> float:
        """Time for a slow disk."""
        return 60.0

    @property
    def batch_timeout_s(self) -> float:
        """As `closing_timeout_s`."""
        return 60.0

    @property
    def replaceable(self) -> bool:
        """No: a new file would truncate the recording."""
        return False

    def connect(self, stream: rr.RecordingStream) -> None:
        """Begin the file.

        Raises:
            EnvironmentFailure: it cannot be written.
        """
        self.check()
        try:
            stream.save(self.path, write_footer=not self._endless)
        except RuntimeError as reason:
            raise self._unwritable(str(reason)) from None

    def check(self) -> None:
        """Check that it can be written; only its folder is created.

        Raises:
            EnvironmentFailure: it cannot.
        """
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            new = not self.path.exists()
            with self.path.open("ab"):
                pass
            if new:
                self.path.unlink()
            free_B = shutil.disk_usage(self.path.parent).free
        except OSError as reason:
            raise self._unwritable(reason.strerror or str(reason)) from None
        if free_B < _ROOM_B:
            raise self._unwritable(f"{free_B >> 20} MiB are free there, {_ROOM_B >> 20} MiB are needed")

    def _unwritable(self, reason: str) -> EnvironmentFailure:
        return EnvironmentFailure(
            f"cannot write {self.path}: {reason}; the recording of the live view was to go there: "
            f"choose another file"
        )

    def alive(self) -> bool:
        """Return whether there is room for more, which is looked for once a second."""
        if time.monotonic() >= self._look_s:
            self._look_s = time.monotonic() + _LOOKING_S
            try:
                self._room = shutil.disk_usage(os.fspath(self.path.parent)).free >= _ROOM_B
            except OSError:
                self._room = False
        return self._room

    def closing_note(self) -> str:
        """Return a note if the disk is full."""
        return "" if self._room else f"less than {_ROOM_B >> 20} MiB are free on its disk"

    def lost(self) -> None:
        """Does nothing: the file is not opened again."""

    def give_up(self) -> None:
        """Does nothing: there is no connection to cut."""
