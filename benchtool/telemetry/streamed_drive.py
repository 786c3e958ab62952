"""Interface of a drive for the stream; `RemoteDrive` implements it."""

from __future__ import annotations

from typing import Protocol

from benchtool.link import DriveAccess, Link, StreamSupervisor


class StreamedDrive(DriveAccess, Protocol):
    """A drive and its link, which is replaced when it is opened again."""

    @property
    def link(self) -> Link: ...
    @property
    def supervisor(self) -> StreamSupervisor | None: ...
