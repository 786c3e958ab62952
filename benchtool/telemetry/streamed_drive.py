"""What the stream asks of a drive: a `RemoteDrive` has it all."""

from __future__ import annotations

from typing import Protocol

from benchtool.link import Link
from benchtool.link.process_data import DriveAccess


class StreamedDrive(DriveAccess, Protocol):
    """A drive and its link, which may become another one when it is opened anew."""

    @property
    def link(self) -> Link: ...
