"""Reading a run bundle, finished or cut short."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchtool.block import Block
from benchtool.errors import NoSuchRecording, RecordingError
from benchtool.recording.events import EVENTS, Event, read_events
from benchtool.recording.failures import reading
from benchtool.recording.integrity import Integrity, check_bundle
from benchtool.recording.manifest import CERTIFICATE, MEASUREMENTS, TABLES, Manifest, read_manifest
from benchtool.recording.seal import read_json
from benchtool.recording.stream_file import DATA, FINISHED, RUNNING, read_parquet, read_stream

PLOTS = "plots"


@dataclass(frozen=True)
class Bundle:
    """A recorded run; blocks are read when asked for. A file whose hash does not fit is not read."""

    directory: Path
    manifest: Manifest
    measurements: dict[str, dict[str, Any]]
    streams: tuple[str, ...]
    integrity: Integrity = field(default_factory=lambda: Integrity(sealed=False))

    @classmethod
    def open(cls, directory: Path, *, checked: bool = False) -> Bundle:
        """Return the bundle in `directory`.

        Args:
            directory: of the bundle.
            checked: skip the comparison with the stored hashes, as it was just made.

        Raises:
            RecordingError: it is not a bundle, or its manifest or measurements are damaged or cannot be read.
        """
        manifest, sealed = read_manifest(directory)
        integrity = Integrity(sealed) if checked else check_bundle(directory, manifest, sealed)
        results = directory / MEASUREMENTS
        _require_intact(directory, integrity, [MEASUREMENTS])
        measurements = read_json(results) if results.is_file() else {}
        with reading(directory / DATA):
            found = {path.stem for path in (directory / DATA).iterdir() if path.suffix in (RUNNING, FINISHED)}
        return cls(directory, manifest, measurements, tuple(sorted(found | set(manifest.streams))), integrity)

    def require_intact(self) -> None:
        """Check that every file is unchanged, except figures and reports.

        Raises:
            RecordingError: one was changed; the message names it.
        """
        _require_intact(self.directory, self.integrity, list(self.integrity.damaged))

    @property
    def complete(self) -> bool:
        """Whether the run was finished; if not, blocks hold the acknowledged data."""
        return self.manifest.complete

    @property
    def certificate(self) -> dict[str, Any] | None:
        """The data-quality certificate; None if the run ended before it was made.

        Raises:
            RecordingError: it cannot be read.
        """
        path = self.directory / CERTIFICATE
        _require_intact(self.directory, self.integrity, [CERTIFICATE])
        return read_json(path) if path.is_file() else None

    @property
    def tables(self) -> dict[str, Any]:
        """Tables of measurements as written; empty if there are none.

        Raises:
            RecordingError: they cannot be read.
        """
        path = self.directory / TABLES
        _require_intact(self.directory, self.integrity, [TABLES])
        return read_json(path) if path.is_file() else {}

    @property
    def events(self) -> tuple[Event, ...]:
        """Events in the order in which they were noted; empty if there are none.

        Raises:
            RecordingError: it cannot be read.
        """
        name = EVENTS.as_posix()
        _require_intact(self.directory, self.integrity, [name])
        return read_events(self.directory, self.integrity.extents.get(name))

    @property
    def plots(self) -> Path:
        """Folder of the figures; it need not exist."""
        return self.directory / PLOTS

    def block(self, stream: str) -> Block:
        """Return all rows of a stream, with its gaps.

        Raises:
            NoSuchRecording: there is no such stream.
            RecordingError: it cannot be read.
        """
        if stream not in self.streams:
            known = ", ".join(self.streams) or "none"
            raise NoSuchRecording(
                f"{self.directory} has no stream '{stream}', it has: {known}; choose one of these"
            )
        finished, running = f"{DATA}/{stream}{FINISHED}", f"{DATA}/{stream}{RUNNING}"
        if (self.directory / finished).is_file() or self.complete:
            _require_intact(self.directory, self.integrity, [finished])
            return read_parquet(self.directory / finished)
        _require_intact(self.directory, self.integrity, [running])
        return read_stream(self.directory / running, self.integrity.extents.get(running))


def _require_intact(directory: Path, integrity: Integrity, names: Sequence[str]) -> None:
    damaged = [name for name in names if name in integrity.damaged]
    if damaged:
        more = f" (and {len(damaged) - 1} more files)" if len(damaged) > 1 else ""
        raise RecordingError(
            f"cannot read {directory / damaged[0]}: {integrity.damaged[damaged[0]]}{more}; the recording was "
            f"damaged or changed after it was made: restore it from a copy, or record again"
        )
