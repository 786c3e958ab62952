"""Writing a run bundle: lossless and synchronous, or an error."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from benchtool.block import Block
from benchtool.errors import RecordingError
from benchtool.recording.checkpoints import Checkpoints
from benchtool.recording.failures import writing
from benchtool.recording.files import require_empty
from benchtool.recording.integrity import files_of
from benchtool.recording.manifest import (
    CERTIFICATE,
    MEASUREMENTS,
    TABLES,
    Manifest,
    StreamInfo,
    write_manifest,
)
from benchtool.recording.reader import Bundle
from benchtool.recording.seal import FileHash, hash_of, write_json
from benchtool.recording.stream_file import DATA, FINISHED, RUNNING, StreamWriter

_STREAM_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


class BundleWriter:
    """Records a run into a directory of its own.

        with BundleWriter(directory, manifest) as bundle:
            bundle.append("capture", block)
            bundle.finish(measurements, verdict="passed")

    Data that `append` has accepted survive any end of the process. Without `finish` the bundle stays marked
    as incomplete and its data stay Arrow streams, which `Bundle` reads as well. The manifest that `finish` or
    `fail` writes has the hashes of all files that are there by then.

    Raises:
        RecordingError: the directory has content or cannot be written.
    """

    def __init__(self, directory: Path, manifest: Manifest) -> None:
        self.directory = directory
        self._manifest = manifest
        self._streams: dict[str, StreamWriter] = {}
        self._checkpoints = Checkpoints(directory)
        self._open = True
        require_empty(directory)
        with writing(directory):
            (directory / DATA).mkdir(parents=True)
        write_manifest(directory, manifest)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self.close()
        except RecordingError:
            if error is None:  # otherwise the first failure is reported
                raise

    def append(self, stream: str, block: Block) -> None:
        """Add rows to a stream, which begins with its first block.

        Ticks missing between two blocks are recorded as a gap.

        Raises:
            RecordingError: the disk is full, the name cannot be a file's, the block does not continue the
                stream (other channels, rate, earlier ticks), or the bundle is finished.
        """
        self._require_open()
        writer = self._streams.get(stream)
        if writer is None:
            if not _STREAM_NAME.fullmatch(stream):
                raise RecordingError(
                    f"'{stream}' cannot name a stream: letters, digits, '_', '-' and '.' are "
                    f"expected: rename it"
                )
            path = self.directory / DATA / f"{stream}{RUNNING}"
            writer = StreamWriter(path, block, self._checkpoints)
            self._streams[stream] = writer
        writer.append(block)

    def finish(
        self,
        measurements: Mapping[str, Mapping[str, Any]] | None = None,
        *,
        verdict: str | None = None,
        quality: Mapping[str, int] | None = None,
        details: Mapping[str, Any] | None = None,
        certificate: Mapping[str, Any] | None = None,
        tables: Mapping[str, Mapping[str, Any]] | None = None,
    ) -> Bundle:
        """Turn the streams into Parquet, write the results, mark the bundle complete and open it.

        `tables` are results of many numbers each, such as spectra; without any there is no file of them.
        `details` and `quality` are added to those the manifest began with; `certificate` is the data-quality
        certificate.

        Raises:
            RecordingError: a file cannot be written; the recorded data stay readable.
        """
        self._require_open()
        self.close()
        known = {}
        for name, stream in self._streams.items():
            target = self.directory / DATA / f"{name}{FINISHED}"
            known[target] = stream.convert(target)
        write_json(self.directory / MEASUREMENTS, measurements or {})
        if tables:
            write_json(self.directory / TABLES, tables)
        if certificate is not None:
            write_json(self.directory / CERTIFICATE, certificate)
        self._close_manifest(verdict, quality, details, known, complete=True)
        return Bundle.open(self.directory, checked=True)

    def fail(
        self,
        reason: str,
        *,
        verdict: str | None = None,
        quality: Mapping[str, int] | None = None,
        details: Mapping[str, Any] | None = None,
        certificate: Mapping[str, Any] | None = None,
    ) -> None:
        """Note in the manifest why the run was cut short; the bundle stays incomplete, its data Arrow
        streams.

        Raises:
            RecordingError: manifest or certificate cannot be written.
        """
        try:
            self.close()
        finally:
            try:
                if certificate is not None:
                    write_json(self.directory / CERTIFICATE, certificate)
            finally:
                stated = dict(details or {}) | {"failure": reason}
                self._close_manifest(verdict, quality, stated, {}, complete=False)

    def _close_manifest(
        self,
        verdict: str | None,
        quality: Mapping[str, int] | None,
        details: Mapping[str, Any] | None,
        known: Mapping[Path, FileHash],
        *,
        complete: bool,
    ) -> None:
        began = self._manifest
        files = {name: known.get(path) or hash_of(path) for name, path in files_of(self.directory).items()}
        update = {
            "verdict": verdict,
            "quality": began.quality | dict(quality or {}),
            "details": began.details | dict(details or {}),
            "streams": {name: _info(stream) for name, stream in self._streams.items()},
            "files": files,
            "complete": complete,
        }
        write_manifest(self.directory, began.model_copy(update=update))
        self._checkpoints.end()

    def close(self) -> None:
        """Release the files without finishing; may be called repeatedly."""
        if self._open:
            self._open = False
            with ExitStack() as streams:  # each is closed, even if another one raises
                for stream in self._streams.values():
                    streams.callback(stream.close)

    def _require_open(self) -> None:
        if not self._open:
            raise RecordingError(
                f"{self.directory} is closed, nothing can be added: record into a new directory"
            )


def _info(stream: StreamWriter) -> StreamInfo:
    return StreamInfo(rows=stream.rows, gaps=len(stream.gaps), missing_rows=stream.missing_rows)
