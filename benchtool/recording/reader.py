"""Reading a run bundle, finished or cut short."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchtool.block import Block
from benchtool.errors import RecordingError
from benchtool.recording.events import Event, read_events
from benchtool.recording.failures import reading
from benchtool.recording.manifest import CERTIFICATE, MEASUREMENTS, Manifest, read_json, read_manifest
from benchtool.recording.stream import read_parquet, read_stream

DATA = "data"
PLOTS = "plots"
RUNNING = ".arrows"
FINISHED = ".parquet"


@dataclass(frozen=True)
class Bundle:
    """A recorded run; blocks are read when asked for."""

    directory: Path
    manifest: Manifest
    measurements: dict[str, dict[str, Any]]
    streams: tuple[str, ...]

    @classmethod
    def open(cls, directory: Path) -> Bundle:
        """The bundle in `directory`.

        Raises:
            RecordingError: it is not a bundle, or its manifest or measurements cannot be read.
        """
        manifest = read_manifest(directory)
        results = directory / MEASUREMENTS
        measurements = read_json(results) if results.is_file() else {}
        with reading(directory / DATA):
            found = {path.stem for path in (directory / DATA).iterdir() if path.suffix in (RUNNING, FINISHED)}
        return cls(directory, manifest, measurements, tuple(sorted(found | set(manifest.streams))))

    @property
    def complete(self) -> bool:
        """Whether the run was finished; if not, blocks hold what was acknowledged until it was cut short."""
        return self.manifest.complete

    @property
    def certificate(self) -> dict[str, Any] | None:
        """How good the data are; None if the run ended before that was known.

        Raises:
            RecordingError: it cannot be read.
        """
        path = self.directory / CERTIFICATE
        return read_json(path) if path.is_file() else None

    @property
    def events(self) -> tuple[Event, ...]:
        """What happened, in the order in which it was noted; none of a run that noted nothing.

        Raises:
            RecordingError: it cannot be read.
        """
        return read_events(self.directory)

    @property
    def plots(self) -> Path:
        """Folder of the figures; it need not exist."""
        return self.directory / PLOTS

    def block(self, stream: str) -> Block:
        """All rows of a stream, with its gaps.

        Raises:
            RecordingError: there is no such stream or it cannot be read.
        """
        if stream not in self.streams:
            known = ", ".join(self.streams) or "none"
            raise RecordingError(
                f"{self.directory} has no stream '{stream}', it has: {known}; choose one of these"
            )
        finished = self.directory / DATA / f"{stream}{FINISHED}"
        if finished.is_file() or self.complete:
            return read_parquet(finished)
        return read_stream(self.directory / DATA / f"{stream}{RUNNING}")
